// SPDX-License-Identifier: Apache-2.0
// What history costs an INS of 21 states at 200 Hz with five fixes a second: `history_bench [SECONDS]`. Late: each second
// has one more fix, which arrives a second late, and live estimates are worked out again from its time on.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "binnacle/run.hpp"
#include "binnacle/session.hpp"
#include "ins_config.hpp"

using namespace binnacle;

namespace {

using Clock = std::chrono::steady_clock;

constexpr Time interval = 5'000'000;
constexpr int rate = 200, fix_every = 40;

double milliseconds_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Stands still, as far as its input and fixes go.
struct Drive {
  explicit Drive(const std::string& history, Estimates shown = Estimates::live)
      : session(Composition::parse(bench::ins_config(21, "", history), "bench.json"), 0, 0, shown),
        imu(session.channel("imu")),
        gnss(session.channel("gnss")) {}

  /// 200 steps and 5 fixes, in milliseconds.
  double second() {
    const auto begin = Clock::now();
    for (int k = 1; k <= rate; ++k) {
      session.push(imu, t, t + interval, increments);
      t += interval;
      if (k % fix_every == 0) session.push(gnss, no_time, t, position);
    }
    return milliseconds_since(begin);
  }
  double late_fix() {
    const auto begin = Clock::now();
    session.push(gnss, no_time, t - nanoseconds_per_second - interval / 2, position);
    return milliseconds_since(begin);
  }
  void check(std::int64_t replayed) const {
    const auto counts = session.counts(session.measurement("fix"));
    if (session.time({0}) == t && counts.replayed == replayed && counts.offered > 0) return;
    std::fprintf(stderr, "%lld fixes were replayed, not %lld\n", static_cast<long long>(counts.replayed),
                 static_cast<long long>(replayed));
    std::exit(1);
  }

  Session session;
  ChannelId imu, gnss;
  Time t = 0;
  double increments[6] = {0, 0, 0, 0, 0, -0.04904};
  double position[3] = {0.8377580409572782, 0.19198621771937624, 500};
};

/// The quickstart at 200 Hz, as `run` does it.
double run_once(const std::string& history, bool may_be_late = false) {
  LoadOptions options;
  options.sets = {R"(/sources/drive/imu_rate="200 Hz")", "/sources/drive/truth_rate=0", "/reference=[]"};
  if (!history.empty()) options.sets.push_back("/filters/ins/history=" + history);
  if (may_be_late) options.sets.push_back("/sources/drive/latency=0");
  const auto composition = Composition::load(BENCH_PROJECT "/configs/quickstart.json", options);
  const auto begin = Clock::now();
  run(composition);
  return milliseconds_since(begin);
}

double median_of(const std::vector<double>& values) { return quantile(values, 0.5); }

}  // namespace

int main(int argc, char** argv) {
  ::setenv("BINNACLE_PLUGIN_PATH", BENCH_PLUGINS, 1);
  const int seconds = argc > 1 ? std::atoi(argv[1]) : 300;
  const std::string history = "\"2 s\"";
  Drive plain(""), late(history), live(history), settled(history, Estimates::settled);
  for (Drive* drive : {&plain, &late, &live, &settled})
    for (int warm = 0; warm < 3; ++warm) drive->second();
  std::vector<double> forward, rerun, of_live, of_settled, of_run, of_late_run;
  for (int second = 0; second < seconds; ++second) {
    forward.push_back(plain.second());
    late.second();
    rerun.push_back(late.late_fix());
    of_live.push_back(live.second() / forward.back());
    of_settled.push_back(settled.second() / forward.back());
  }
  plain.check(0);
  late.check(seconds);
  for (int pair = 0; pair < std::max(5, seconds / 10); ++pair) {
    const double without = run_once("");
    of_run.push_back(run_once(history) / without);
    of_late_run.push_back(run_once(history, true) / without);
  }
  std::printf("200 steps and 5 fixes, 21 states  p50 %.3f ms, p99 %.3f ms\n", quantile(forward, 0.5),
              quantile(forward, 0.99));
  std::printf("a fix that is 1 s late            p50 %.3f ms, p99 %.3f ms: %.2f x of p50 forward, %.2f x of p99\n",
              quantile(rerun, 0.5), quantile(rerun, 0.99), quantile(rerun, 0.99) / quantile(forward, 0.5),
              quantile(rerun, 0.99) / quantile(forward, 0.99));
  std::printf("nothing late, live estimates      %.3f x\n", median_of(of_live));
  std::printf("nothing late, settled estimates   %.3f x\n", median_of(of_settled));
  std::printf("nothing late, a run of quickstart %.3f x\n", median_of(of_run));
  std::printf("with a latency of 0 s at its source %.3f x\n", median_of(of_late_run));
  std::printf("memory for a second of history    %.0f kB\n", static_cast<double>(late.session.snapshot_size()) / 2e3);
  return 0;
}
