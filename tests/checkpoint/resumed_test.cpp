// SPDX-License-Identifier: Apache-2.0
// A run that goes on from any of its checkpoints leaves what the run leaves that was not stopped: summary, records, sinks.
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "catch.hpp"
#include "recorded.hpp"
#include "score/run.hpp"

namespace resumed_test {

using namespace binnacle;

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Bytes = std::vector<std::byte>;

/// Everything that a run shows, in one number that every bit of it is in.
class Seen final : public score::RunObserver, StepObserver {
 public:
  void record(int filter, Time t, std::span<const double> values) override {
    mix(&filter, sizeof filter);
    mix(&t, sizeof t);
    mix(values.data(), values.size_bytes());
  }
  StepObserver* step_observer(int) override { return this; }
  void offered(const UpdateRecord& record) override {
    mix(&record.t, sizeof record.t);
    mix(&record.outcome, sizeof record.outcome);
    mix(record.reason, std::strlen(record.reason));
    if (record.residual) mix(record.residual, sizeof(double) * static_cast<std::size_t>(record.rows));
  }
  void scored(int, const score::ErrorSeries& errors) override {
    mix(errors.t.data(), errors.t.size_bytes());
    mix(errors.values.data(), errors.values.size_bytes());
    mix(errors.sigma.data(), errors.sigma.size_bytes());
  }
  void exchange(StateBytes& bytes) override {
    bytes.value(hash);
    bytes.value(count);
  }

  std::uint64_t hash = 0xcbf29ce484222325u;
  std::int64_t count = 0;

 private:
  void mix(const void* data, std::size_t bytes) {
    const auto* at = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) hash = (hash ^ at[i]) * 0x100000001b3u;
    ++count;
  }
};

/// Without times of the machine.
Json without_times(const Json& from) {
  if (!from.is_structured()) return from;
  Json to = from;
  for (const char* key : {"wall_s", "filter_s"})
    if (to.is_object()) to.erase(key);
  for (auto& item : to) item = without_times(item);
  return to;
}

struct Left {
  std::string summary;
  std::uint64_t hash = 0;
  std::int64_t count = 0;
  std::string sink;

  bool operator==(const Left&) const = default;
};

struct Case {
  std::string config;
  std::vector<std::string> sets = {};
  std::string sink = {};  // the file that one of the sets names
};

Left run(const Case& from, Checkpoints checkpoints, std::uint64_t seed = 1) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions load;
  if (from.config.starts_with("drives/")) load.vars["drives"] = recorded::data()->string();
  load.sets = from.sets;
  if (!from.sink.empty()) fs::remove(from.sink);
  const auto composition = score::load(BINNACLE_TEST_PROJECT "/configs/" + from.config + ".json", load);
  Seen seen;
  score::RunOptions options;
  options.seed = seed;
  options.observer = &seen;
  options.checkpoints = std::move(checkpoints);
  const auto result = score::run(composition, options);
  std::string sink;
  if (!from.sink.empty()) {
    std::ifstream file(from.sink);
    sink.assign(std::istreambuf_iterator<char>(file), {});
    REQUIRE(sink.size() > 100);
  }
  return {without_times(result.summary).dump(1) + result.warnings.text() + result.failures.text() +
              result.doubts.text(),
          seen.hash, seen.count, sink};
}

struct Kept final : Checkpoints::Keeper {
  void keep(std::span<const std::byte> checkpoint) override { all.emplace_back(checkpoint.begin(), checkpoint.end()); }
  std::vector<Bytes> all;
};

void goes_on(const Case& from, Time every, std::size_t at_least) {
  CAPTURE(from.config);
  const Left whole = run(from, {});
  REQUIRE(whole.count > 100);
  Kept keeper;
  const std::vector<Bytes>& kept = keeper.all;
  CHECK(run(from, {.every = every, .keeper = &keeper}) == whole);
  REQUIRE(kept.size() >= at_least);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    CAPTURE(i, kept.size());
    const Left resumed = run(from, {.from = kept[i]});
    REQUIRE(resumed.summary == whole.summary);
    REQUIRE(resumed.count == whole.count);
    REQUIRE(resumed.hash == whole.hash);
    REQUIRE(resumed.sink == whole.sink);
  }
  // And again from a checkpoint of a run that was resumed.
  Kept later;
  run(from, {.every = every, .keeper = &later, .from = kept[kept.size() / 2]});
  REQUIRE(later.all.size() > 1);
  CHECK(run(from, {.from = later.all[later.all.size() / 2]}) == whole);
}

constexpr Time s = nanoseconds_per_second;

std::string sink(const std::string& channel, const std::string& file) {
  return R"(/sinks/out={"type": "csv_writer", "input": ")" + channel + R"(", "path": ")" + file +
         R"(", "fields": {"height": "position.height"}, "columns": {"height": {"unit": "m"}}})";
}

std::string scratch(const char* name) { return (fs::temp_directory_path() / name).string(); }

const std::string late = R"(/sources/drive/latency={"uniform": [0, "1.9 s"]})";

}  // namespace

TEST_CASE("resumed: a simulated drive with implied causes, records and a file") {
  const auto file = scratch("binnacle_checkpoint_plain.csv");
  goes_on({"quickstart", {sink("ins", file)}, file}, 13 * s, 14);
}
TEST_CASE("resumed: P as a factor, with history") {
  for (const char* form : {"ud", "square_root"})
    goes_on({"quickstart", {std::string("/filters/ins/covariance=") + form, R"(/filters/ins/history="2 s")", late}},
            31 * s, 5);
}
TEST_CASE("resumed: samples under way, history, settled estimates and live ones") {
  const auto file = scratch("binnacle_checkpoint_live.csv");
  goes_on({"quickstart", {late, R"(/filters/ins/history="2 s")", sink("ins", file)}, file}, 31 * s, 5);
}
TEST_CASE("resumed: live estimates are scored") {
  goes_on({"quickstart", {late, R"(/filters/ins/history="1 s")", R"(/evaluate/estimates="live")"}}, 31 * s, 5);
}
TEST_CASE("resumed: smoothing over an interval") {
  goes_on({"quickstart", {R"(/filters/ins/smoother="fixed_interval")"}}, 31 * s, 5);
}
TEST_CASE("resumed: a fixed lag, scored, and as a channel") {
  const auto file = scratch("binnacle_checkpoint_lag.csv");
  goes_on({"quickstart",
           {R"(/filters/ins/smoother={"type": "fixed_lag", "lag": "5 s", "every": "2 s"})", sink("ins.smoothed", file)},
           file},
          31 * s, 5);
}
TEST_CASE("resumed: a transfer alignment with adapted noise and withheld samples") {
  goes_on({"transfer_alignment/one_beta"}, 7 * s, 3);
}
TEST_CASE("resumed: faults, gates, recovery") {
  goes_on({"quickstart",
           {R"(/transforms/bad={"type": "faults", "input": "drive.gnss", "faults": [
              {"kind": "step", "fields": ["lat"], "by": "60 m", "from": "80 s", "until": "110 s"},
              {"kind": "duplicate", "share": 0.1}]})",
            "/filters/ins/measurements/fix/channel=bad"}},
          31 * s, 5);
}
TEST_CASE("resumed: a recorded drive with detectors, mounting and likely causes") {
  if (!recorded::data()) return;
  goes_on({"drives/stop-go-large-mount"}, 60 * s, 3);
}
TEST_CASE("resumed: another recorded drive") {
  if (!recorded::data()) return;
  goes_on({"drives/mixed-turns"}, 60 * s, 3);
}

TEST_CASE("a checkpoint of something else, or a torn one, is refused with the reason") {
  const Case from{"quickstart"};
  Kept keeper;
  run(from, {.every = 100 * s, .keeper = &keeper});
  const Bytes& kept = keeper.all.back();
  const auto refusal = [&](const Case& other, const Bytes& bytes, std::uint64_t seed = 1) {
    try {
      run(other, {.from = bytes}, seed);
    } catch (const ConfigError& error) {
      CHECK(error.diagnostics().items().front().code == "B084");
      return error.diagnostics().items().front().message;
    }
    return std::string("it was taken");
  };
  const auto has = [](const std::string& text, const char* part) {
    INFO(text);
    CHECK(text.find(part) != std::string::npos);
  };
  has(refusal({"quickstart", {"/filters/ins/measurements/fix/gate=0.99"}}, kept), "another config");
  has(refusal(from, kept, 2), "belongs to seed 1, run 0, and this is seed 2, run 0");
  has(refusal(from, {kept.begin(), kept.begin() + 20}), "incomplete");
  has(refusal(from, {kept.begin(), kept.end() - 1}), "damaged");
  has(refusal(from, Bytes(200)), "not a checkpoint");
  for (const std::size_t at : {std::size_t{200}, kept.size() / 2, kept.size() - 1}) {
    Bytes flipped = kept;
    flipped[at] ^= std::byte{4};
    has(refusal(from, flipped), "damaged");
  }
  Bytes foreign = kept;
  foreign[8] = std::byte{'z'};
  has(refusal(from, foreign), "another kind of machine");
}

}  // namespace resumed_test
