// SPDX-License-Identifier: Apache-2.0
// What models are given besides the state, and what they give besides numbers: auxiliary channels of process models, steps
// that bridge a hole, notes.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <unistd.h>

#include "allocations.hpp"
#include "binnacle/run.hpp"
#include "binnacle/session.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace model_input_test {

using namespace binnacle;

namespace {

constexpr Time s = 1'000'000'000;

const std::string pushed = R"(
    "speed": {"type": "pushed", "fields": {"v": {"unit": "m/s", "kind": "rate"}}},
    "wind": {"type": "pushed", "fields": {"w": {"unit": "m/s"}}},
    "z": {"type": "pushed", "fields": {"z": {"unit": "m"}}})";

/// x is carried by the channels that `inputs` names, and seen as it is and through a derived block.
std::shared_ptr<const Composition> carried(const std::string& inputs, const std::string& sources = pushed) {
  return filter_tests::composition_of(R"({"binnacle": 1, "sources": {)" + sources + R"(},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1}},
      "derived": {"again": {"type": "watchful", "blocks": {"x": "x"}}},
      "process": {"go": {"type": "carried", "input": "speed", "blocks": {"x": "x"})" +
                                      inputs + R"(}},
      "measurements": {"see": {"type": "wary", "channel": "z", "blocks": {"x": "again"}}}}}})");
}

const std::string by_wind = R"(, "inputs": {"wind": "wind"})";

std::vector<std::string> lines(const Diagnostics& diagnostics) {
  std::vector<std::string> text;
  for (const auto& item : diagnostics.items()) text.push_back(item.code + " " + item.pointer + " " + item.message);
  return text;
}

/// The errors of a config.
std::string errors_of(const std::string& inputs, const std::string& sources = pushed) {
  try {
    carried(inputs, sources);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

class Carrying {
 public:
  explicit Carrying(const std::shared_ptr<const Composition>& composition) : session(composition) {}
  void speed(Time t0, Time t1, double v) { push("speed", t0, t1, v); }
  void wind(Time t, double w) { push("wind", no_time, t, w); }
  void see(Time t, double z) { push("z", no_time, t, z); }
  double x() {
    double value = 0;
    session.read(session.block("x"), {&value, 1});
    return value;
  }
  double variance() { return session.covariance(session.block("x"))(0, 0); }
  std::vector<std::string> notes() { return lines(session.notes(session.filter("f"))); }

  Session session;

 private:
  void push(const char* channel, Time t0, Time t, double value) {
    session.push(session.channel(channel), t0, t, {&value, 1});
  }
};

}  // namespace

TEST_CASE("a process model is given the latest sample of its auxiliary channel") {
  Carrying run(carried(by_wind));
  run.wind(0, 0.5);
  run.speed(0, 1 * s, 1);
  CHECK(run.x() == 1.5);
  run.wind(1 * s, 2);
  run.speed(1 * s, 2 * s, 1);
  CHECK(run.x() == 4.5);
  run.speed(2 * s, 3 * s, 0);
  CHECK(run.x() == 6.5);
  CHECK(run.notes().empty());
}

TEST_CASE("an auxiliary channel that has emitted nothing is not available, one that is left open neither") {
  Carrying waiting(carried(by_wind)), open(carried(""));
  for (Carrying* run : {&waiting, &open}) {
    run->speed(0, 1 * s, 1);
    run->speed(1 * s, 2 * s, 1);
    CHECK(run->x() == 2);
  }
  CHECK(open.notes().empty());
  CHECK(waiting.notes() ==
        std::vector<std::string>{
            "B083 /filters/f/process/go plugin 'probe', component 'carried' (/filters/f/process/go): "
            "propagate at 1 s notes: no wind has come (2 times)"});
}

TEST_CASE("rows of an auxiliary channel reach a process model, and a snapshot keeps them") {
  const std::string gusts =
      R"(, "gusts": {"type": "pushed", "max_rows": 3, "fields": {"w_1": {"unit": "m/s", "per_row": true}}})";
  const auto composition = carried(R"(, "inputs": {"gusts": "gusts"})", pushed + gusts);
  Carrying run(composition);
  const double each[] = {1, 2, 4};
  SampleView sample;
  sample.t = 0;
  sample.rows = 3;
  sample.row_fields = each;
  run.session.push(run.session.channel("gusts"), sample);
  run.speed(0, 1 * s, 0);
  CHECK(run.x() == 7);
  std::vector<std::byte> bytes(run.session.snapshot_size());
  run.session.snapshot(bytes);
  Carrying other(composition);
  other.session.restore(bytes);
  other.speed(1 * s, 2 * s, 0);
  CHECK(other.x() == 14);
}

TEST_CASE("what is wrong with a process model's auxiliary channels is reported") {
  CHECK(errors_of(R"(, "inputs": {"wind": "wnd"})").find("there is no channel 'wnd'; did you mean 'wind'?") !=
        std::string::npos);
  CHECK(errors_of(R"(, "inputs": {"wnd": "wind"})").find("did you mean 'wind'") != std::string::npos);
  CHECK(errors_of(R"(, "inputs": {"wind": "z"})").find("channel 'z' has no field 'w' (m/s) that 'carried' needs") !=
        std::string::npos);
  CHECK(errors_of(R"(, "inputs": {"wind": "wind"}, "fields": {"w": "w"})").empty());
}

TEST_CASE("a step that bridges a hole says so to process, measurement and derived models, and no other does") {
  Carrying run(carried(""));
  run.speed(0, 1 * s, 1);
  run.see(1 * s, 1);
  CHECK(run.notes().empty());
  run.see(4 * s, 3);           // waits for the input, and falls into the hole
  run.speed(5 * s, 6 * s, 1);  // 1 s to 5 s are missing
  run.see(6 * s, 6);
  const std::string wary =
      "B083 /filters/f/measurements/see plugin 'probe', component 'wary' (/filters/f/measurements/see): ";
  CHECK(run.notes() == std::vector<std::string>{
                           "B083 /filters/f/process/go plugin 'probe', component 'carried' (/filters/f/process/go): "
                           "propagate at 4 s notes: bridges a hole (2 times)",
                           "B083 /filters/f/derived/again plugin 'probe', component 'watchful' "
                           "(/filters/f/derived/again): evaluate at 4 s notes: derived over a hole",
                           wary + "linearize at 4 s notes: seen after a hole"});
}

TEST_CASE("a model adds what noise a hole deserves") {
  Carrying run(carried(""));
  run.speed(0, 1 * s, 1);
  const double before = run.variance();
  run.speed(5 * s, 6 * s, 1);
  CHECK(run.variance() == before + 4);
  CHECK(run.x() == 6);
}

TEST_CASE("a note that is left again allocates nothing, and reset forgets all") {
  Carrying run(carried(by_wind));
  const auto speed = run.session.channel("speed");
  const double v[] = {1};
  run.session.push(speed, 0, 1 * s, v);
  const auto before = conform::allocations();
  for (Time t = 1; t < 100; ++t) run.session.push(speed, t * s, (t + 1) * s, v);
  CHECK(conform::allocations() == before);
  REQUIRE(run.notes().size() == 1);
  CHECK(run.notes().front().find("(100 times)") != std::string::npos);
  run.session.reset();
  CHECK(run.notes().empty());
}

TEST_CASE("notes are warnings of a run") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("notes." + std::to_string(::getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "speed.csv") << "t,v\n1,1\n2,1\n3,1\n8,1\n9,1\n";
  const std::string sources = R"("speed": {"type": "csv", "path": ")" + (folder / "speed.csv").string() +
                              R"(", "time": {"column": "t", "unit": "s"}, "interval": "1 s",
        "columns": {"v": {"unit": "m/s", "kind": "rate"}}},
      "z": {"type": "pushed", "fields": {"z": {"unit": "m"}}})";
  /// When each note comes: at 8 s the hole before it is bridged, and a last sample follows.
  class Listed : public RunObserver {
   public:
    void noted(const Diagnostic& note) override { notes.emplace_back(instants, note.message); }
    void after_instant() override { ++instants; }
    int instants = 0;
    std::vector<std::pair<int, std::string>> notes;
  } listed;
  RunOptions options;
  options.observer = &listed;
  const RunResult result = run(carried("", sources), options);
  fs::remove_all(folder);
  REQUIRE(listed.notes.size() == 1);
  CHECK(listed.notes.front().first < 5);
  CHECK(listed.notes.front().second.find("bridges a hole") != std::string::npos);
  REQUIRE(result.failures.empty());
  REQUIRE(lines(result.warnings).size() == 1);
  CHECK(result.warnings.items().front().origin.line > 0);
  const std::string text = "propagate at 7 s notes: bridges a hole";
  CHECK(lines(result.warnings).front().find(text) != std::string::npos);
}

TEST_CASE("a measurement that has no time in common with the driving input is a warning with both spans") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("spans." + std::to_string(::getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "speed.csv") << "t,v\n1,1\n2,1\n3,1\n";
  const auto warned = [&](const std::string& rows) {
    std::ofstream(folder / "z.csv") << "t,z\n" << rows;
    const auto csv = [&](const std::string& name) {
      return R"({"type": "csv", "path": ")" + (folder / name).string() + R"(", "time": {"column": "t", "unit": "s"}, )";
    };
    const auto composition =
        filter_tests::composition_of(R"({"binnacle": 1,
      "sources": {"speed": )" + csv("speed.csv") +
                                     R"("interval": "1 s", "columns": {"v": {"unit": "m/s", "kind": "rate"}}},
                  "z": )" + csv("z.csv") +
                                     R"("columns": {"z0": {"column": "z", "unit": "m"}}}},
      "filters": {"f": {
        "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1}},
        "process": {"go": {"type": "carried", "input": "speed", "blocks": {"x": "x"}}},
        "measurements": {"see": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [1]}}}}})");
    return lines(run(composition).warnings);
  };
  CHECK(warned("2,1\n3,1\n").empty());
  const std::vector<std::string> apart{
      "B114 /filters/f/measurements/see channel 'z' has no time in common with the input: speed from 1 s to 3 s, z "
      "from "
      "18 s to 19 s; is the offset or the unit of a time missing?"};
  CHECK(warned("18,1\n19,1\n") == apart);
  fs::remove_all(folder);
}

}  // namespace model_input_test
