// SPDX-License-Identifier: Apache-2.0
// What smoothing an hour of 15 states at 200 Hz costs, as a ratio to the forward run alone in the same process, and how much
// memory it takes: `smooth_bench [MINUTES] [PAIRS]`.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <sys/resource.h>

#include "binnacle/run.hpp"
#include "smooth/fixed_lag.hpp"
#include "smooth/interval_smoother.hpp"

using namespace binnacle;

namespace {

/// The quickstart's filter on a drive of so many minutes.
std::shared_ptr<const Composition> drive(int minutes) {
  ::setenv("BINNACLE_PLUGIN_PATH", BENCH_PLUGINS, 1);
  std::string segments = R"([{"do": "still", "duration": "20 s"})";
  for (int i = 0; i < minutes; ++i)
    segments += R"(, {"do": "accelerate", "to": "14 m/s", "acceleration": "1.5 m/s^2"},
                     {"do": "turn", "angle": ")" +
                std::string(i % 2 ? "-90" : "90") + R"( deg", "rate": ")" + std::string(i % 2 ? "-10" : "10") +
                R"( deg/s"}, {"do": "straight", "duration": "30 s"},
                     {"do": "accelerate", "to": 0, "acceleration": "-2 m/s^2"})";
  LoadOptions options;
  options.sets = {"/sources/drive/segments=" + segments + "]", R"(/sources/drive/imu_rate="200 Hz")",
                  "/sources/drive/truth_rate=0", "/reference=[]"};
  return Composition::load(BENCH_PROJECT "/configs/quickstart.json", options);
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto of = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return of(usage.ru_utime) + of(usage.ru_stime);
}

/// Smooths, and marks an estimate each `every`.
class Smoothed final : public RunObserver {
 public:
  explicit Smoothed(Time every) : every_(every) {}
  void begin(Session& session) override {
    session_ = &session;
    smoother_ = std::make_unique<smooth::IntervalSmoother>(session);
    filter_ = std::make_unique<smooth::SmoothedFilter>(session, 0);
  }
  void after_instant() override { smoother_->after_instant(); }
  void finished() override {
    const auto mark = [&](smooth::SmoothedFilter&) {
      const Time period = session_->started({0}) ? session_->time({0}) / every_ : last_;
      if (std::exchange(last_, period) != period) filter_->mark();
    };
    const auto sweep = [&](smooth::SmoothedFilter&) {
      filter_->sweep([&](const smooth::Epoch& epoch) { epochs += epoch.P(0, 0) > 0; }, [](smooth::WithheldSample) {});
    };
    smoother_->run_back({{filter_.get()}, mark, sweep});
  }
  std::int64_t epochs = 0;

 private:
  Time every_, last_ = -1;
  Session* session_ = nullptr;
  std::unique_ptr<smooth::IntervalSmoother> smoother_;
  std::unique_ptr<smooth::SmoothedFilter> filter_;
};

/// Smooths with a lag, on the way.
class Lagging final : public RunObserver {
 public:
  explicit Lagging(smooth::Lag lag) : lag_(lag) {}
  void begin(Session& session) override {
    smoother_ = std::make_unique<smooth::FixedLag>(session, FilterId{0}, lag_,
                                                   [&](const smooth::Epoch& epoch) { epochs += epoch.P(0, 0) > 0; });
    session.attach({0}, smoother_.get());
  }
  void finished() override { smoother_->finish(); }
  std::int64_t epochs = 0;

 private:
  smooth::Lag lag_;
  std::unique_ptr<smooth::FixedLag> smoother_;
};

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

template <class Run>
double cpu_of(Run&& run) {
  const double before = cpu_seconds();
  run();
  return cpu_seconds() - before;
}

}  // namespace

int main(int argc, char** argv) {
  const int minutes = argc > 1 ? std::atoi(argv[1]) : 60, pairs = argc > 2 ? std::atoi(argv[2]) : 5;
  const auto composition = drive(minutes);
  std::vector<double> forward, each_second, every_epoch, lag;
  std::int64_t seconds_smoothed = 0, epochs_smoothed = 0, lagged = 0;
  const auto smooth = [&](Time every, std::int64_t& epochs) {
    Smoothed smoothed(every);
    RunOptions options;
    options.observer = &smoothed;
    const double cpu = cpu_of([&] { run(composition, options); });
    epochs = smoothed.epochs;
    return cpu;
  };
  for (int pair = 0; pair < pairs; ++pair) {
    const double alone = cpu_of([&] { run(composition); });
    forward.push_back(alone);
    each_second.push_back(smooth(nanoseconds_per_second, seconds_smoothed) / alone);
    every_epoch.push_back(smooth(1, epochs_smoothed) / alone);
    Lagging lagging({5 * nanoseconds_per_second, nanoseconds_per_second});
    RunOptions options;
    options.observer = &lagging;
    lag.push_back(cpu_of([&] { run(composition, options); }) / alone);
    lagged = lagging.epochs;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("forward alone                     %.2f s\n", median(forward));
  std::printf("smoothed, %7lld covariances     %.2f x\n", static_cast<long long>(seconds_smoothed),
              median(each_second));
  std::printf("smoothed, %7lld covariances     %.2f x\n", static_cast<long long>(epochs_smoothed), median(every_epoch));
  std::printf("lag of 5 s, swept each second, %7lld covariances  %.2f x\n", static_cast<long long>(lagged),
              median(lag));
  std::printf("largest memory                    %.0f MB\n", static_cast<double>(usage.ru_maxrss) / 1024);
  return seconds_smoothed > 0 && epochs_smoothed > seconds_smoothed ? 0 : 1;
}
