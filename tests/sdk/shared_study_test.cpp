// SPDX-License-Identifier: Apache-2.0
// Variants that draw the same samples share them, and no figure of any depends on it.
#include "catch.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <stdexcept>

#include "binnacle/catalog.hpp"
#include "binnacle/random.hpp"
#include "binnacle/registry.hpp"
#include "binnacle/run_together.hpp"
#include "binnacle/source.hpp"
#include "command.hpp"
#include "drive_study.hpp"
#include "run/runtime.hpp"
#include "run/shared_feed.hpp"
#include "score/run.hpp"
#include "study/study.hpp"
#include "study/workers.hpp"

namespace shared_study_test {

using namespace binnacle;
using namespace binnacle::test;
using internal::runtime::Runtime;
using internal::runtime::SharedFeed;
using internal::runtime::Taps;

namespace {

bool always() { return true; }

/// Calls into the components below, by all threads.
struct Calls {
  std::atomic<int> opened{0}, asked{0}, echoed{0};
  std::atomic<int> longest_wait{0};  // samples that were drawn before one that a transform receives
  void forget() { opened = asked = echoed = longest_wait = 0; }
};
Calls calls;

double normal(binnacle::random::Philox& random) {
  return binnacle::random::uniform(random) - 0.5 + binnacle::random::uniform(random);
}

/// `samples` of a place that wanders, ten a second, and what it was; after `fails_at` of them it cannot go on.
class Ticks final : public Source {
 public:
  struct State {
    std::int64_t given = 0;
    double place = 0;
    binnacle::random::Philox random{};
  };
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "ticks";
    spec.summary = "A place that wanders.";
    spec.parameters = {parameter::integer("samples").at_least(1).defaults("300").about("how many"),
                       parameter::integer("fails_at").at_least(0).defaults("1000000").about("sample that it throws at"),
                       parameter::number("level", "m").defaults("0").about("where it begins")};
    spec.example = "{}";
    return spec;
  }
  explicit Ticks(const Binding& binding)
      : samples_(binding.parameters().integer("samples")),
        fails_at_(binding.parameters().integer("fails_at")),
        level_(binding.parameters().number("level")) {
    ChannelDeclaration seen("z"), truth("truth");
    z_ = seen.carries(field::level("z0", "m"));
    x_ = truth.carries(field::level("x", "m"));
    seen_ = declaration_.emits(std::move(seen));
    truth_ = declaration_.emits(std::move(truth));
    state_ = declaration_.keeps<State>();
  }
  void open(Reporter&) override { ++calls.opened; }
  SourceStatus next(const MemoryView& memory, SourceOutput& out) const override {
    ++calls.asked;
    State& state = memory[state_];
    const std::int64_t tick = state.given++ / 2;
    if (tick == fails_at_) throw std::runtime_error("the cable is torn");
    if (tick == samples_) return SourceStatus::end;
    const bool is_first = state.given % 2 == 1;
    if (is_first) state.place += 0.1 * normal(state.random);
    SampleWriter& sample = out.on(is_first ? seen_ : truth_);
    sample.t = nanoseconds(0.1 * static_cast<double>(tick));
    if (is_first)
      sample[z_] = state.place + 0.3 * normal(state.random);
    else
      sample[x_] = state.place;
    return SourceStatus::sample;
  }

 private:
  void initialise(std::uint64_t seed, const MemoryView& memory) const override {
    memory[state_].random = binnacle::random::stream(seed, "ticks");
    memory[state_].place = level_;
  }
  std::int64_t samples_, fails_at_;
  double level_;
  OutputField z_, x_;
  OutputChannel seen_, truth_;
  Memory<State> state_;
};

/// What it receives, with noise of its own; every fifth comes twice, the tenth does not come at all.
class Echo final : public Transform {
 public:
  struct State {
    std::int64_t received = 0;
    binnacle::random::Philox random{};
  };
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "echo";
    spec.summary = "Noise on what it receives.";
    spec.inputs = {input("of", {field::level("z0", "m")})};
    spec.parameters = {parameter::number("noise", "m").defaults("0.1").about("how much")};
    spec.example = "{}";
    return spec;
  }
  explicit Echo(const Binding& binding)
      : noise_(binding.parameters().number("noise")), from_(binding.field(binding.input("of"), "z0")) {
    ChannelDeclaration channel("");
    z_ = channel.carries(field::level("z0", "m"));
    channel_ = declaration_.emits(std::move(channel));
    state_ = declaration_.keeps<State>();
  }
  void on(const TransformInput& in, Emitter& out) const override {
    ++calls.echoed;
    State& state = in.memory[state_];
    if (++state.received == 10) return;
    calls.longest_wait = std::max<int>(calls.longest_wait, calls.asked - 2 * static_cast<int>(state.received));
    SampleWriter& sample = out.on(channel_);
    sample.t = in.sample.t;
    sample[z_] = in.sample[from_] + noise_ * normal(state.random);
    out.emit(channel_);
    if (state.received % 5 == 0) out.emit_again(channel_);
  }

 private:
  void initialise(std::uint64_t seed, const MemoryView& memory) const override {
    memory[state_].random = binnacle::random::stream(seed, "echo");
  }
  double noise_;
  Field from_;
  OutputField z_;
  OutputChannel channel_;
  Memory<State> state_;
};

/// Emits nothing, and says what it has received.
class Stuck final : public Transform {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "stuck";
    spec.summary = "Emits nothing.";
    spec.parameters = {parameter::integer("throws_at").at_least(0).defaults("1000000").about("sample")};
    spec.inputs = {input("of", {field::level("z0", "m")})};
    spec.example = "{}";
    return spec;
  }
  explicit Stuck(const Binding& binding) : throws_at_(binding.parameters().integer("throws_at")) {
    ChannelDeclaration channel("");
    channel.carries(field::level("z0", "m"));
    declaration_.emits(std::move(channel));
    received_ = declaration_.keeps<std::int64_t>();
  }
  void on(const TransformInput& in, Emitter&) const override {
    if (++in.memory[received_] == throws_at_) throw std::runtime_error("it is stuck for good");
  }
  std::string waits_for(const MemoryView& memory) const override {
    return "it has " + std::to_string(memory[received_]) + " samples of 1000";
  }

 private:
  std::int64_t throws_at_;
  Memory<std::int64_t> received_;
};

std::string put(std::string text, const std::string& token, const std::string& value) {
  return text.replace(text.find(token), token.size(), value);
}

std::string study_text(const std::string& variants) {
  return put(R"~({ "binnacle": 1, "title": "Ticks",
    "sources": { "ticks": { "type": "ticks" } },
    "transforms": { "echo": { "type": "echo", "input": "ticks.z" } },
    "filters": { "walk": {
      "blocks": { "place": { "type": "vector", "size": 1, "unit": "m", "init": { "x": "0 m" }, "sigma": "1 m" } },
      "process": { "wander": { "type": "random_walk", "blocks": { "x": "place" }, "q": "0.2 m/sqrt(s)" } },
      "measurements": { "seen": { "type": "linear_measurement", "channel": "echo", "blocks": { "x": "place" },
                                  "sigma": ["0.2 m"], "gate": 0.999 } } } },
    "reference": [ { "channel": "ticks.truth", "blocks": { "walk/place": ["x"] } } ],
    "study": { "runs": 4, "seed": 3, "variants": { VARIANTS },
               "metrics": ["walk/place.x/rms", "walk/place.x/final", "walk/seen/nis", "walk/place/nees"] } })~",
             "VARIANTS", variants);
}

/// A variant whose filter takes the samples to be so good; `more`: what else it changes, ", KEY: …".
std::string variant(const char* name, const char* sigma, const std::string& more = "") {
  const std::string patch =
      R"("NAME": { "filters": { "walk": { "measurements": { "seen": { "sigma": ["SIGMA"] } } } } MORE })";
  return put(put(put(patch, "NAME", name), "SIGMA", sigma), "MORE", more);
}

study::Study load(const Workbench& bench, const std::string& text) {
  bench.write("ticks.json", text);
  study::StudyOptions options;
  options.load.sets = {"/plugins=[\"" BINNACLE_TEST_PLUGINS "\"]"};
  options.load.linked_plugins = {
      std::make_shared<const LinkedPlugin>(LinkedPlugin{"ticking", "1.0.0", [](Registry& registry) {
                                                          registry.add<Ticks>();
                                                          registry.add<Echo>();
                                                          registry.add<Stuck>();
                                                        }})};
  return study::Study::load(bench.path("ticks.json"), options);
}

bool is_same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

void check_same(const study::Figures& a, const study::Figures& b) {
  CHECK(a.state == b.state);
  CHECK(a.failure == b.failure);
  CHECK(a.verdict == b.verdict);
  REQUIRE(a.values.size() == b.values.size());
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    CHECK(is_same(a.values[i].value, b.values[i].value));
    CHECK(is_same(a.values[i].dof, b.values[i].dof));
    CHECK(is_same(a.values[i].n, b.values[i].n));
  }
}

/// All of a study's first runs as groups, and each variant alone: equal to the bit. How often what was called, in the groups.
void check_shared_as_alone(const study::Study& study, int runs = 2) {
  for (int run = 0; run < runs; ++run)
    for (const auto& group : study.groups()) {
      const auto together = study.carry_out(group, run, always);
      REQUIRE(together.size() == group.size());
      for (std::size_t i = 0; i < group.size(); ++i)
        check_same(together[i], study.carry_out({group[i]}, run, always)[0]);
    }
}

using Groups = std::vector<std::vector<std::size_t>>;

}  // namespace

TEST_CASE("variants share what is drawn, and each has the figures to the bit that it has alone") {
  const Workbench bench;
  const auto study =
      load(bench, study_text(variant("a", "0.1 m") + "," + variant("b", "0.2 m") + "," + variant("c", "0.8 m")));
  CHECK(study.groups() == Groups{{0, 1, 2}});
  calls.forget();
  const auto together = study.carry_out({0, 1, 2}, 1, always);
  CHECK(calls.asked == 601);  // 300 samples on two channels, and the end
  CHECK(calls.echoed == 300);
  CHECK(calls.opened == 1);
  REQUIRE(together[0].state == study::Figures::State::finished);
  CHECK(together[0].values[0].value != together[1].values[0].value);
  check_shared_as_alone(study, 4);
  CHECK(calls.opened == 1);
}

TEST_CASE("forms of P, filters with history and gates that refuse share to the bit") {
  const Workbench bench;
  const auto study = load(bench, study_text(variant("a", "0.1 m") + "," + variant("tight", "0.01 m") + "," + R"(
      "ud": { "filters": { "walk": { "covariance": "ud" } } },
      "late": { "filters": { "walk": { "history": "2 s" } } })"));
  CHECK(study.groups() == Groups{{0, 1, 2, 3}});
  check_shared_as_alone(study);
}

TEST_CASE("what differs in a source is drawn apart, and a transform that differs shares its source") {
  const Workbench bench;
  const auto study =
      load(bench,
           study_text(variant("a", "0.1 m") + "," + variant("b", "0.2 m") + "," +
                      variant("longer", "0.2 m", R"(, "sources": { "ticks": { "samples": 310 } })") + "," +
                      variant("louder", "0.2 m", R"(, "transforms": { "echo": { "noise": "0.2 m" } })") + "," +
                      variant("same", "0.4 m", R"(, "sources": { "ticks": { "samples": 300, "level": "0 cm" } })")));
  CHECK(study.groups() == Groups{{0, 1, 3, 4}, {2}});
  calls.forget();
  const auto together = study.carry_out({0, 1, 3, 4}, 0, always);
  CHECK(calls.asked == 601);
  CHECK(calls.echoed == 600);
  CHECK(calls.longest_wait > 20);  // one echo works once the other has had its turn
  CHECK(calls.longest_wait < 100);
  CHECK(together[1].values[0].value != together[2].values[0].value);
  check_shared_as_alone(study);
}

TEST_CASE("samples on their way arrive alike for all that share them") {
  const Workbench bench;
  const std::string late = R"("sources": { "ticks": { "latency": { "uniform": ["0 s", "0.5 s"] } } })";
  const std::string history = R"("filters": { "walk": { "history": "1 s" } })";
  const auto study = load(bench, study_text(R"("one": { )" + late + R"( }, "two": { )" + late + "," + history + R"( },
      "at once": {} )"));
  CHECK(study.groups() == Groups{{0, 1}, {2}});
  check_shared_as_alone(study);
}

TEST_CASE("a variant that breaks among others breaks alone, with what it says alone") {
  const Workbench bench;
  const std::string waiting = R"~({ "filters": { "walk": { "blocks": { "place": { "init": {
      "x": null, "channel": "never", "fields": { "x": "z0" } } } } } },
      "transforms": { "never": { "type": "stuck", "input": "ticks.z" } } })~";
  const std::string broken =
      R"~("broken": { "filters": { "walk": { "process": { "wander": { "q": "1e200 m/sqrt(s)" } } } } })~";
  const auto study = load(bench, study_text(variant("good", "0.2 m") + ", " + broken + R"(, "waiting": )" + waiting +
                                            R"(, "waiting too": )" + waiting));
  REQUIRE(study.groups() == Groups{{0, 1, 2, 3}});
  const auto figures = study.carry_out(study.groups()[0], 0, always);
  CHECK(figures[0].state == study::Figures::State::finished);
  CHECK(figures[1].state == study::Figures::State::failed);
  for (const std::size_t waits : {2u, 3u})
    CHECK(figures[waits].failure.find("it has 300 samples of 1000") != std::string::npos);
  check_shared_as_alone(study);
}

TEST_CASE("the others go on from where a run ended that made samples for them") {
  const Workbench bench;
  const std::string thrown =
      R"("thrown": { "transforms": { "never": { "type": "stuck", "input": "ticks.z", "throws_at": 150 } } })";
  const auto study = load(bench, study_text(thrown + "," + variant("a", "0.1 m") + "," + variant("b", "0.2 m")));
  REQUIRE(study.groups() == Groups{{0, 1, 2}});
  const auto figures = study.carry_out({0, 1, 2}, 0, always);
  CHECK(figures[0].failure.find("it is stuck for good") != std::string::npos);
  CHECK(figures[1].state == study::Figures::State::finished);
  check_shared_as_alone(study);
}

TEST_CASE("a source that breaks ends all that share it, each with its own words") {
  const Workbench bench;
  const auto torn =
      load(bench, study_text(variant("a", "0.1 m", R"(, "sources": { "ticks": { "fails_at": 100 } })") + "," +
                             variant("b", "0.2 m", R"(, "sources": { "ticks": { "fails_at": 100 } })")));
  CHECK(torn.groups() == Groups{{0, 1}});
  const auto figures = torn.carry_out({0, 1}, 0, always);
  for (const auto& each : figures) {
    CHECK(each.state == study::Figures::State::failed);
    CHECK(each.failure.find("the cable is torn") != std::string::npos);
  }
  check_shared_as_alone(torn);
}

TEST_CASE("smoothing that goes back over the samples has its own") {
  const Workbench bench;
  const auto study =
      load(bench, study_text(variant("a", "0.1 m") + "," + variant("b", "0.2 m") + "," +
                             R"("smoothed": { "filters": { "walk": { "smoother": "fixed_interval" } } })"));
  CHECK(study.groups() == Groups{{0, 1}, {2}});
  check_shared_as_alone(study);
}

TEST_CASE("a study asks its sources once a run, and again only for threads that have nothing else to do") {
  const Workbench bench;
  std::string variants;
  for (int i = 0; i < 20; ++i) variants += (i ? "," : "") + variant(("v" + std::to_string(i)).c_str(), "0.1 m");
  const auto asked = [&](const study::Study& study, int runs, int jobs) {
    study::Results results(study.variants().size(), static_cast<std::size_t>(runs));
    calls.forget();
    std::size_t done = 0;
    study::carry_out_all(study, results, jobs, always, [&](auto, auto, const auto&) { ++done; });
    CHECK(done == study.variants().size() * static_cast<std::size_t>(runs));
    CHECK(calls.asked % 601 == 0);
    return calls.asked / 601;
  };
  const auto four = load(bench, study_text(variant("a", "0.1 m") + "," + variant("b", "0.1 m") + "," +
                                           variant("c", "0.1 m") + "," + variant("d", "0.1 m")));
  CHECK(asked(four, 3, 1) == 3);
  CHECK(asked(four, 4, 2) == 4);
  CHECK(asked(four, 5, 2) == 6);  // the last run in two halves
  CHECK(asked(four, 1, 3) == 3);
  CHECK(asked(four, 1, 8) == 4);
  CHECK(asked(load(bench, study_text(variants)), 2, 1) == 4);  // sixteen at a time at most
}

TEST_CASE("the command's figures do not depend on who shares with whom") {
  const Workbench bench;
  write_drive(bench);
  for (const char* jobs : {"1", "2", "3"})
    REQUIRE(binnacle::test::binnacle(bench, {"study", "drive.json", "--jobs", jobs, "--out", jobs, "--quiet"}).status ==
            0);
  check_same_files(bench, "1", "2");
  check_same_files(bench, "1", "3");
}

TEST_CASE("a feed keeps what one of its runs has still to take, and no more") {
  const Workbench bench;
  const auto study = load(bench, study_text(variant("a", "0.1 m") + "," + variant("b", "0.2 m")));
  Runtime first(study.variants()[0].composition->plan(), true), second(study.variants()[1].composition->plan(), true);
  SharedFeed feed;
  std::vector<Taps*> taps;
  for (Runtime* runtime : {&first, &second}) {
    runtime->reset(1, 0);
    taps.push_back(&feed.add(*runtime));
    runtime->read_from(taps.back());
  }
  const auto go = [&](Runtime& runtime, int instants) {
    for (int i = 0; i < instants; ++i) REQUIRE(runtime.next_instant());
    feed.forget_taken();
  };
  const auto& [source, echo] = std::pair(taps[0]->sources[0].stream, taps[0]->transforms[0].stream);
  CHECK(taps[1]->sources[0].stream == source);
  CHECK(taps[1]->transforms[0].stream == echo);
  go(first, 100);
  CHECK(source->begin() == 0);
  CHECK(source->end() == 201);  // the next one is at hand
  go(second, 60);
  CHECK(source->begin() == 121);
  CHECK(echo->begin() == taps[1]->transforms[0].place);
  go(second, 60);  // which makes what the first has not asked for
  CHECK(source->begin() == 201);
  CHECK(source->end() == 241);
  feed.remove(*taps[0]);
  feed.forget_taken();
  CHECK(source->begin() == 241);
  CHECK(echo->begin() == echo->end());
}

TEST_CASE("what cannot run together is refused") {
  const Workbench bench;
  const auto study = load(bench, study_text(variant("a", "0.1 m") + "," +
                                            variant("b", "0.1 m", R"(, "sources": { "ticks": { "level": "1 m" } })")));
  const auto& a = study.variants()[0].composition;
  const auto& b = study.variants()[1].composition;
  CHECK(have_same_sources(*a, *a));
  CHECK(!have_same_sources(*a, *b));
  std::vector<RunRequest> requests{{a}, {b}};
  CHECK_THROWS_AS(run_together(requests), std::invalid_argument);
  requests[1] = {a};
  requests[1].options.seed = 2;
  CHECK_THROWS_AS(run_together(requests), std::invalid_argument);
  requests[1].options.seed = 1;
  requests[1].options.pace = 1;
  CHECK_THROWS_AS(run_together(requests), std::invalid_argument);
}

}  // namespace shared_study_test
