// SPDX-License-Identifier: Apache-2.0
// Samples that arrive late, in any order, within the history: what is settled has the bits of the ordered run without history.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "binnacle/run.hpp"
#include "catch.hpp"
#include "recorded.hpp"
#include "score/sections.hpp"

namespace shuffled_test {

using namespace binnacle;

namespace {

#ifdef NDEBUG
constexpr int seeds = 100;
#else
constexpr int seeds = 10;  // of five, three leave one of the configs in order
#endif

/// All that a run leaves, to the bit: time, state and P after each instant, references, and at the end counts and doubts.
class Bits final : public RunObserver {
 public:
  explicit Bits(bool is_settled) : is_settled_(is_settled) {}

  void begin(Session& session) override {
    session_ = &session;
    last_.assign(session.composition().filters().size(), no_time);
  }
  void sampled(int channel, const SampleView& sample) override {
    if (!is_settled_) reference(channel, sample);
  }
  void settled(int channel, const SampleView& sample) override {
    if (is_settled_) reference(channel, sample);
  }
  void after_instant() override {
    for (int f = 0; f < static_cast<int>(last_.size()); ++f) {
      auto& last = last_[static_cast<std::size_t>(f)];
      if (!session_->started({f}) || session_->time({f}) == last) continue;
      last = session_->time({f});
      mix(&last, sizeof last);
      const auto x = session_->state({f});
      mix(x.data(), x.size_bytes());
      const auto P = session_->covariance(FilterId{f});
      for (int j = 0; j < P.cols; ++j) mix(&P(0, j), sizeof(double) * static_cast<std::size_t>(P.rows));
      hashes.push_back(hash_);
    }
  }
  void finished() override {
    after_instant();
    for (int f = 0; f < static_cast<int>(last_.size()); ++f) {
      const auto& filter = session_->composition().filters()[static_cast<std::size_t>(f)];
      for (int m = 0; m < static_cast<int>(filter.measurements.size()); ++m) {
        const auto counts = session_->counts(MeasurementId{{f}, m});
        end += filter.name + "/" + filter.measurements[static_cast<std::size_t>(m)].name + " " +
               std::to_string(counts.offered);
        for (const auto count : counts.by_outcome) end += " " + std::to_string(count);
        end += " recovered " + std::to_string(counts.recoveries) + " " + number(counts.nis_mean) + counts.last_reason;
        for (const auto& row : counts.rows)
          end += "; " + number(row.mean) + number(row.rms) + number(row.correlation) + number(row.fitting_sigma);
        end += "\n";
        replayed += counts.replayed;
      }
      end += std::to_string(session_->counts(FilterId{f}).steps) + " steps, " +
             std::to_string(session_->counts(FilterId{f}).input_gaps) + " gaps\n";
      end += session_->doubts({f}).text() + session_->diagnosis({f});
    }
  }

  std::vector<std::uint64_t> hashes;
  std::string end;
  std::int64_t replayed = 0;

 private:
  static std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, " %a", value);
    return text;
  }
  void reference(int channel, const SampleView& sample) {
    const std::string& name = session_->composition().channels()[static_cast<std::size_t>(channel)].name;
    mix(name.data(), name.size());
    mix(&sample.t, sizeof sample.t);
    mix(sample.fields, sizeof(double));
    hashes.push_back(hash_);
  }
  void mix(const void* data, std::size_t bytes) {
    const auto* at = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < bytes; ++i) hash_ = (hash_ ^ at[i]) * 0x100000001b3u;
  }

  bool is_settled_;
  Session* session_ = nullptr;
  std::vector<Time> last_;
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

std::shared_ptr<const Composition> load(const std::string& config, std::vector<std::string> sets) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions load;
  if (config.starts_with("drives/")) load.vars["drives"] = recorded::data()->string();
  load.sets = std::move(sets);
  return score::load(BINNACLE_TEST_PROJECT "/configs/" + config + ".json", load);
}

Bits run_of(const std::shared_ptr<const Composition>& composition, bool is_settled) {
  Bits bits(is_settled);
  RunOptions options;
  options.observer = &bits;
  options.feeds_sinks = false;
  run(composition, options);
  return bits;
}

/// Each source late in its own way, by no more than 2 s: not at all, by a time of its own, by anything, or in bursts.
std::vector<std::string> latencies(const Composition& composition, unsigned seed) {
  std::mt19937 random(seed);
  const auto time = [&] { return std::to_string(std::uniform_real_distribution<double>(0, 1.95)(random)); };
  std::vector<std::string> sets;
  for (const auto& source : composition.sources()) {
    const std::string at = "/sources/" + source.name + "/latency=";
    const auto kind = random() % 7;
    if (kind == 0) continue;
    if (kind == 6) sets.push_back(at + "{\"batch\": " + std::to_string(0.05 + std::stod(time())) + "}");
    if (kind == 1) sets.push_back(at + time());
    if (kind > 1 && kind < 6) sets.push_back(at + "{\"uniform\": [0, " + time() + "]}");
  }
  return sets;
}

void is_settled_like_ordered(const std::string& config, const std::string& filter, std::vector<std::string> sets = {}) {
  const Bits ordered = run_of(load(config, sets), false);
  REQUIRE(ordered.hashes.size() > 100);
  int with_replays = 0;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    CAPTURE(config, seed);
    auto late = sets;
    late.push_back("/filters/" + filter + "/history=\"2 s\"");
    for (auto& set : latencies(*load(config, sets), seed)) late.push_back(std::move(set));
    const Bits settled = run_of(load(config, late), true);
    REQUIRE(settled.hashes.size() == ordered.hashes.size());
    const auto different = std::ranges::mismatch(settled.hashes, ordered.hashes).in1 - settled.hashes.begin();
    REQUIRE(different == static_cast<std::ptrdiff_t>(ordered.hashes.size()));
    REQUIRE(settled.end == ordered.end);
    with_replays += settled.replayed > 0;
  }
  CHECK(2 * with_replays >= seeds);
}

const std::vector<std::string> spoilt = {
    R"(/transforms/bad={"type": "faults", "input": "gnss", "faults": [
      {"kind": "step", "fields": ["lat"], "by": "60 m", "from": "80 s", "until": "110 s"},
      {"kind": "duplicate", "share": 0.1}]})",
    "/filters/ins/measurements/fix/channel=bad"};

}  // namespace

TEST_CASE("shuffled: a simulated drive") { is_settled_like_ordered("quickstart", "ins"); }
TEST_CASE("shuffled: displacements from copies of the state") {
  is_settled_like_ordered("clone/outage", "ins",
                          {"/sources/drive/imu_rate=20 Hz",
                           "/sources/drive/segments=[{\"do\": \"still\", \"duration\": \"5 s\"}, {\"do\": "
                           "\"accelerate\", \"to\": 10, \"acceleration\": 2}, {\"do\": \"turn\", \"angle\": "
                           "1.5, \"rate\": 0.2}, {\"do\": \"straight\", \"duration\": \"20 s\"}]"});
}
TEST_CASE("shuffled: a transfer alignment with adapted noise") {
  is_settled_like_ordered("transfer_alignment/one_beta", "align");
}
TEST_CASE("shuffled: a recorded drive with detectors, mounting and the non-holonomic constraint") {
  if (!recorded::data()) return;
  is_settled_like_ordered("drives/stop-go-large-mount", "ins");
}
TEST_CASE("shuffled: a recorded drive whose fixes jump and come twice, and are recovered") {
  if (!recorded::data()) return;
  is_settled_like_ordered("drives/parkinglot", "ins", spoilt);
}
TEST_CASE("shuffled: another recorded drive") {
  if (!recorded::data()) return;
  is_settled_like_ordered("drives/mixed-turns", "ins");
}

}  // namespace shuffled_test
