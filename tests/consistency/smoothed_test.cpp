// SPDX-License-Identifier: Apache-2.0
// A smoothed INS knows how wrong it is, is better than the filter, and does not depend on where its snapshots were.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <boost/math/distributions/chi_squared.hpp>

#include "binnacle/run.hpp"
#include "catch.hpp"
#include "score/run.hpp"
#include "smooth/interval_smoother.hpp"

namespace smoothed_test {

using namespace binnacle;

namespace {

/// Turns and climbs between; all that is scored there is far from both ends.
const std::vector<double> instants = {20, 75, 140, 180};
constexpr int runs = 200;
constexpr double confidence = 0.99;

std::shared_ptr<const Composition> matched(const std::vector<std::string>& sets) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = sets;
  return score::load(BINNACLE_TEST_PROJECT "/tests/consistency/matched.json", options);
}

/// NEES and squared errors at the picked instants, by series.
struct Watch : score::RunObserver {
  void scored(int filter, const score::ErrorSeries& errors) override {
    if (filter != 1) return;
    for (std::size_t i = 0; i < instants.size(); ++i)
      for (std::size_t k = 0; k < errors.t.size(); ++k)
        if (std::abs(seconds(errors.t[k]) - instants[i]) < 0.3) {
          sums[errors.name][i] += errors.values[k];
          ++counts[errors.name][i];
          break;
        }
  }
  std::map<std::string, std::map<std::size_t, double>> sums;
  std::map<std::string, std::map<std::size_t, int>> counts;
};

}  // namespace

TEST_CASE("the NEES of a smoothed INS is that of chi-square") {
  const auto composition = matched({"/filters/ins/smoother=fixed_interval", "/record/every=10 s"});
  Watch watch;
  for (int run = 0; run < runs; ++run) {
    score::RunOptions options;
    options.seed = 4711;
    options.run = run;
    options.observer = &watch;
    score::run(composition, options);
  }
  // The biases have a reference as well.
  const std::map<std::string, double> names = {{"position.nees", 3},
                                               {"velocity.nees", 3},
                                               {"attitude.nees", 3},
                                               {"state.nees", 15}};
  const double probability = 1 - (1 - confidence) / static_cast<double>(names.size() * instants.size());
  for (const auto& [name, dof] : names) {
    const boost::math::chi_squared distribution(dof * runs);
    const double low = boost::math::quantile(distribution, (1 - probability) / 2) / runs;
    const double high = boost::math::quantile(boost::math::complement(distribution, (1 - probability) / 2)) / runs;
    for (std::size_t i = 0; i < instants.size(); ++i) {
      CAPTURE(name, instants[i]);
      REQUIRE(watch.counts[name][i] == runs);
      const double mean = watch.sums[name][i] / runs;
      std::printf("smoothed %s at %.0f s: %.3f (%.3f … %.3f)\n", name.c_str(), instants[i], mean, low, high);
      CHECK(mean > low);
      CHECK(mean < high);
    }
  }
}

namespace {

/// Smooths every estimate of a run, with stretches of so many instants.
class Everything final : public RunObserver {
 public:
  explicit Everything(std::int64_t length) : length_(length) {}
  void begin(Session& session) override {
    session_ = &session;
    smoother_ = std::make_unique<smooth::IntervalSmoother>(session, length_);
    filter_ = std::make_unique<smooth::SmoothedFilter>(session, 0);
  }
  void after_instant() override { smoother_->after_instant(); }
  void finished() override {
    std::vector<std::byte> before(session_->snapshot_size()), after(before.size());
    session_->snapshot(before);
    smoother_->run_back({{filter_.get()},
                         [&](smooth::SmoothedFilter&) { filter_->mark(); },
                         [&](smooth::SmoothedFilter&) {
                           filter_->sweep(
                               [&](const smooth::Epoch& epoch) {
                                 numbers.insert(numbers.end(), epoch.x, epoch.x + filter_->info().stored_size);
                                 numbers.insert(numbers.end(), epoch.P.data,
                                                epoch.P.data + epoch.P.rows * epoch.P.cols);
                               },
                               [](smooth::WithheldSample) {});
                         }});
    session_->snapshot(after);
    CHECK((before == after));
  }
  std::vector<double> numbers;

 private:
  std::int64_t length_;
  Session* session_ = nullptr;
  std::unique_ptr<smooth::IntervalSmoother> smoother_;
  std::unique_ptr<smooth::SmoothedFilter> filter_;
};

std::vector<double> smoothed_by(std::int64_t length) {
  static const auto composition = matched({});
  Everything everything(length);
  RunOptions options;
  options.observer = &everything;
  const RunResult result = run(composition, options);
  CHECK_FALSE(result.failures.has_errors());
  return everything.numbers;
}

}  // namespace

TEST_CASE("what is smoothed is the same to the bit, however often a snapshot was taken") {
  const auto whole = smoothed_by(1'000'000'000);
  CHECK(whole.size() > 10'000);
  CHECK((smoothed_by(1000) == whole));
  CHECK((smoothed_by(7) == whole));  // so many snapshots that stretches become longer
}

}  // namespace smoothed_test
