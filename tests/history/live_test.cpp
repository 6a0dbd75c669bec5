// SPDX-License-Identifier: Apache-2.0
// A session with history, sample by sample: live estimates, what is settled, what is too late, snapshots, cascades.
#include <algorithm>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "catch.hpp"
#include "line.hpp"
#include "snapshot_attack.hpp"

namespace live_test {

using namespace binnacle;
using binnacle::test::Contains;
using filter_tests::composition_of;
using filter_tests::fix_and_speed;

namespace {

struct Sample {
  const char* channel;
  double t, value;
  double arrival;
};

/// Fixes and speeds, none of the same time, which arrive up to `latency` late.
std::vector<Sample> arriving(unsigned seed, int count, double latency) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> delay(0, latency);
  std::normal_distribution<double> noise;
  std::vector<Sample> all;
  for (int k = 0; k < count; ++k) {
    const double t = 0.1 * k;
    all.push_back({"z", t, 0.5 * t + noise(random) + (k % 19 == 7 ? 60 : 0), t + delay(random)});
    all.push_back({"v", t + 0.03, 0.5 + 0.1 * noise(random), t + 0.03 + delay(random)});
  }
  std::ranges::stable_sort(all, {}, &Sample::arrival);
  return all;
}

std::string with_history(const std::string& history) {
  std::string text = fix_and_speed(R"("sigma": [1], "gate": 0.99)", R"("sigma": [0.1])");
  const auto at = text.find("\"blocks\": {\"position\"");
  return text.substr(0, at) + (history.empty() ? "" : "\"history\": " + history + ", ") + text.substr(at);
}

void push(Session& session, const Sample& sample) {
  filter_tests::push(session, sample.channel, sample.t, {sample.value});
}

/// Time, state and covariance.
std::vector<double> bits(const Session& session, FilterId filter = {0}) {
  std::vector<double> all{seconds(session.time(filter))};
  all.insert(all.end(), session.state(filter).begin(), session.state(filter).end());
  const ConstMatrixView P = session.covariance(filter);
  for (int j = 0; j < P.cols; ++j)
    for (int i = 0; i < P.rows; ++i) all.push_back(P(i, j));
  return all;
}

std::vector<double> ordered(const std::shared_ptr<const Composition>& composition, std::vector<Sample> samples) {
  std::ranges::stable_sort(samples, {}, &Sample::t);
  Session session(composition);
  for (const Sample& sample : samples) push(session, sample);
  return bits(session);
}

}  // namespace

TEST_CASE("live estimates are those of an ordered run over what has arrived, after every sample") {
  const auto plain = composition_of(with_history("")), late = composition_of(with_history("\"2 s\""));
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto samples = arriving(seed, 60, 1.8);
    Session session(late);
    std::vector<Sample> arrived;
    for (const Sample& sample : samples) {
      push(session, sample);
      arrived.push_back(sample);
      CAPTURE(seed, arrived.size());
      REQUIRE(bits(session) == ordered(plain, arrived));
    }
    CHECK(session.counts(session.measurement("fix")).replayed > 20);
    CHECK(session.counts(session.measurement("fix")).longest_delay > nanoseconds(1.0));
  }
}

TEST_CASE("settled estimates are those of the ordered run, as far as nothing can come before them") {
  const auto plain = composition_of(with_history("")), late = composition_of(with_history("\"2 s\""));
  const auto samples = arriving(3, 100, 1.9);
  Session session(late, 0, 0, Estimates::settled);
  double newest = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    push(session, samples[k]);
    newest = std::max(newest, samples[k].t);
    std::vector<Sample> settled;
    std::ranges::copy_if(samples, std::back_inserter(settled), [&](const Sample& sample) {
      return nanoseconds(newest) - nanoseconds(sample.t) > nanoseconds(2.0);
    });
    if (settled.empty()) continue;
    REQUIRE(bits(session) == ordered(plain, settled));
  }
}

TEST_CASE("what comes later than the history is late, and each filter has its own") {
  std::string text = with_history("\"2 s\"");
  const auto filter = text.substr(text.find("\"f\": {") + 5, text.rfind("}}") - text.find("\"f\": {") - 5);
  std::string other = filter;
  other.replace(other.find("2 s"), 3, "0.5 s");
  text = text.substr(0, text.rfind("}}")) + ", \"short\": " + other + "}}";
  Session session(composition_of(text));
  for (int k = 0; k < 50; ++k) push(session, {"z", 0.1 * k, 0, 0});
  push(session, {"z", 4.55, 0, 0});  // 0.35 s late
  push(session, {"z", 4.05, 0, 0});  // 0.85 s
  push(session, {"z", 2.05, 0, 0});  // 2.85 s
  const auto of_long = session.counts(session.measurement("f/fix"));
  const auto of_short = session.counts(session.measurement("short/fix"));
  const auto late = static_cast<int>(Outcome::late);
  CHECK(std::tuple(of_long.offered, of_long.replayed, of_long.by_outcome[late]) == std::tuple(53, 2, 1));
  CHECK(std::tuple(of_short.offered, of_short.replayed, of_short.by_outcome[late]) == std::tuple(53, 1, 2));
  CHECK(of_long.longest_delay == nanoseconds(4.9) - nanoseconds(4.05));
  CHECK(of_short.last_reason == "older than the filter's history");
}

TEST_CASE("a snapshot of a session with history goes on bit for bit, also what is under way") {
  const auto composition = composition_of(with_history("\"2 s\""));
  const auto samples = arriving(4, 100, 1.9);
  for (const Estimates shown : {Estimates::live, Estimates::settled}) {
    Session whole(composition, 0, 0, shown), other(composition, 0, 0, shown);
    std::vector<std::byte> bytes;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      push(whole, samples[k]);
      if (k == 90) {
        bytes.resize(whole.snapshot_size());
        whole.snapshot(bytes);
        push(other, samples[k]);  // what it was is forgotten
        other.restore(bytes);
      }
      if (k > 90) push(other, samples[k]);
      if (k >= 90) REQUIRE(bits(other) == bits(whole));
    }
    CHECK(other.counts(other.measurement("fix")).replayed == whole.counts(whole.measurement("fix")).replayed);
    const auto before = bits(other);
    bytes.resize(bytes.size() - 100);
    snapshot_attack::reseal(bytes);
    CHECK_THROWS_WITH(other.restore(bytes), Contains("its content is damaged"));
    CHECK(bits(other) == before);
  }
}

TEST_CASE("a damaged snapshot of a session with history is refused, and a forged one is too or it is gone on with") {
  const auto composition = composition_of(with_history("\"2 s\""));
  const auto samples = arriving(4, 100, 1.9);
  for (const Estimates shown : {Estimates::live, Estimates::settled}) {
    Session session(composition, 0, 0, shown);
    for (std::size_t k = 0; k < 150; ++k) push(session, samples[k]);
    const auto whole = snapshot_attack::snapshot_of(session);
    std::mt19937_64 random(9);
    int taken = 0;
    for (int k = 0; k < 1000; ++k) taken += snapshot_attack::is_taken(session, snapshot_attack::damaged(whole, random));
    CHECK(taken == 0);
    for (int k = 0; k < 3000; ++k)
      taken += snapshot_attack::survives_forged(session, whole, random, [&](Session& its) {
        for (std::size_t next = 150; next < samples.size(); ++next) push(its, samples[next]);
      });
    CAPTURE(taken);
    CHECK(taken > 30);
    CHECK(taken < 3000);
  }
}

TEST_CASE("observers learn when what they saw is void") {
  struct Watch final : StepObserver {
    std::vector<Time> rewinds;
    Time t = no_time;
    void rewound(Time to) override {
      rewinds.push_back(to);
      t = to;
    }
    void stepped(const StepRecord& record) override {
      CHECK((t == no_time || record.t0 == t));
      t = record.t1;
    }
  } watch;
  Session session(composition_of(with_history("\"2 s\"")));
  session.attach({0}, &watch);
  const auto samples = arriving(5, 60, 1.0);
  for (const Sample& sample : samples) push(session, sample);
  CHECK(watch.rewinds.size() > 20);
  CHECK(watch.t == session.time({0}));
}

namespace {

/// Instants that the live estimates worked on: here each has a step or a measurement.
struct Work final : StepObserver {
  std::int64_t rewinds = 0;
  std::vector<Time> instants;
  void rewound(Time) override { ++rewinds; }
  void stepped(const StepRecord& record) override { seen(record.t1); }
  void offered(const UpdateRecord& record) override { seen(record.t); }

 private:
  void seen(Time t) {
    if (instants.empty() || instants.back() != t) instants.push_back(t);
  }
};

}  // namespace

TEST_CASE("a budget bounds what an arrival costs, and what it left is made up for") {
  const auto plain = composition_of(with_history("")),
             bounded = composition_of(with_history(R"({"length": "4 s", "steps": 8})"));
  auto samples = arriving(6, 80, 0);
  for (std::size_t k = 0; k < samples.size(); k += 17) samples[k].arrival += 1.5;  // back over some 30 instants
  std::ranges::stable_sort(samples, {}, &Sample::arrival);
  Session session(bounded);
  Work work;
  session.attach({0}, &work);
  std::vector<Sample> arrived;
  std::int64_t behind = 0, present = 0, most = 0;
  for (const Sample& sample : samples) {
    work.instants.clear();
    push(session, sample);
    arrived.push_back(sample);
    most = std::max<std::int64_t>(most, std::ssize(work.instants));
    const bool is_present = session.time({0}) == nanoseconds(std::ranges::max(arrived, {}, &Sample::t).t);
    ++(is_present ? present : behind);
    if (is_present) REQUIRE(bits(session) == ordered(plain, arrived));
  }
  CHECK(most == 8);
  CHECK(behind > 10);
  CHECK(present > 60);
  CHECK(work.rewinds >= 8);
  for (int k = 0; k < 10; ++k) session.commit(nanoseconds(arrived.back().t));  // nothing comes any more
  CHECK(bits(session) == ordered(plain, arrived));
  const Time lag = session.counts(FilterId{0}).longest_lag;
  CHECK(lag > nanoseconds(0.5));
  CHECK(lag < nanoseconds(2.5));
  CHECK(session.verdict({0}) == Verdict::ok);
}

TEST_CASE(
    "with a budget that is too small, late samples are refused until the estimates are there, and they are doubtful") {
  const auto composition = composition_of(with_history(R"({"length": "1 s", "steps": 2})"));
  for (const Estimates shown : {Estimates::live, Estimates::settled}) {
    Session session(composition, 0, 0, shown);
    std::int64_t pushed = 0;
    for (int k = 0; k < 2000; ++k) {
      const double t = 0.005 * k;
      push(session, {"z", t, 0, t});
      if (k < 300 || k % 4 != 0) continue;
      push(session, {"v", t - 0.999, 0, t});
      ++pushed;
    }
    const auto speed = session.counts(session.measurement("speed"));
    const auto late = speed.by_outcome[static_cast<int>(Outcome::late)];
    if (shown == Estimates::settled) {  // alone it is never behind
      CHECK(late == 0);
      CHECK(session.verdict({0}) == Verdict::ok);
      continue;
    }
    CHECK(late > 0);
    CHECK(late < pushed);
    CHECK(speed.last_reason == "late, and the live estimates lagged behind");
    CHECK(session.counts(FilterId{0}).longest_lag > nanoseconds(1.0));
    REQUIRE(session.verdict({0}) == Verdict::doubtful);
    const Diagnostics doubts = session.doubts({0});
    REQUIRE(doubts.items().size() == 1);
    CHECK(doubts.items().front().code == "B123");
    CHECK_THAT(doubts.items().front().message, Contains("s behind the arrivals") && Contains("history 1 s"));
  }
}

TEST_CASE("nothing is settled before its work is done, and a budget bounds that work too") {
  const auto plain = composition_of(with_history("")),
             bounded = composition_of(with_history(R"({"length": "1 s", "steps": 3})"));
  auto samples = arriving(8, 40, 0);
  samples.push_back({"z", 60.0, 30, 60.0});  // after it 80 instants are due at once
  Session session(bounded, 0, 0, Estimates::settled);
  for (const Sample& sample : samples) push(session, sample);
  std::size_t settled = 0;
  for (; session.time({0}) < nanoseconds(samples[79].t); ++settled) {
    const auto until = session.time({0});
    std::vector<Sample> before;
    std::ranges::copy_if(samples, std::back_inserter(before), [&](const auto& s) { return nanoseconds(s.t) <= until; });
    REQUIRE(bits(session) == ordered(plain, before));
    REQUIRE(settled < 100);
    session.commit(nanoseconds(60.0));
  }
  CHECK(settled > 5);
  CHECK(settled < 10);
}

}  // namespace live_test
