// SPDX-License-Identifier: Apache-2.0
// Paper 000 from a start error of a degree: NEES of the attitude and NIS, averaged over runs, epoch by epoch, in a world that is
// the filter's model (configs/transfer_alignment/start_error.json).
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>

#include "catch.hpp"
#include "plan.hpp"  // of sdk/score
#include "run/runtime.hpp"
#include "score/run.hpp"

namespace alignment_start_test {

using namespace binnacle;

namespace {

constexpr std::uint64_t seed = 1;  // of the config
constexpr double settled = 5;      // s: the criterion's

std::shared_ptr<const Composition> load(const std::vector<std::string>& sets) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = sets;
  return score::load(BINNACLE_TEST_PROJECT "/configs/transfer_alignment/start_error.json", options);
}

/// Sums over runs by epoch.
struct Series {
  void add(Time t, double value) {
    const auto epoch = static_cast<std::size_t>(std::lround(seconds(t) * 5));
    if (sum.size() <= epoch) sum.resize(epoch + 1, 0.0), count.resize(epoch + 1, 0);
    sum[epoch] += value;
    ++count[epoch];
  }
  std::vector<double> sum;
  std::vector<int> count;
};

/// How many of the epochs from `settled` on have their mean over runs where 99 % of such means lie, and the mean of all.
struct Share {
  Share(const Series& series, int dof, int runs) {
    const boost::math::chi_squared distribution(static_cast<double>(dof) * runs);
    const double low = boost::math::quantile(distribution, 0.005) / runs;
    const double high = boost::math::quantile(boost::math::complement(distribution, 0.005)) / runs;
    int epochs = 0, inside = 0;
    for (std::size_t k = static_cast<std::size_t>(settled * 5); k < series.sum.size(); ++k) {
      if (series.count[k] != runs) continue;
      const double value = series.sum[k] / runs;
      mean += value;
      ++epochs;
      inside += value > low && value < high;
    }
    REQUIRE(epochs > 470);
    mean /= epochs;
    share = double(inside) / epochs;
  }
  double share = 0, mean = 0;
};

/// Of the attitude against the truth, at each truth sample, and of the accepted matches.
class Watch final : public StepObserver {
 public:
  Watch(internal::runtime::Runtime& runtime, const Composition& composition)
      : engine_(runtime.engine(0)), scored_(score::plan_of(composition)), plan_(runtime.plan().filters.front()) {
    for (const auto& reference : scored_->references)
      if (plan_.blocks[static_cast<std::size_t>(reference.block)].name == "attitude") reference_ = &reference;
    REQUIRE(reference_);
    runtime.subscribe([this](int channel, const SampleView& sample) {
      if (channel == reference_->channel) compare(sample);
    });
    engine_.attach(this);
  }
  void offered(const UpdateRecord& record) override {
    if (record.outcome == Outcome::accepted) nis.add(record.t, record.nis);
  }
  Series nees, nis;

 private:
  void compare(const SampleView& truth) {
    if (!engine_.started() || engine_.status().t != truth.t) return;
    const auto& block = plan_.blocks[static_cast<std::size_t>(reference_->block)];
    std::vector<double> outputs, stored(static_cast<std::size_t>(block.declaration().stored_size));
    for (const int field : reference_->fields) outputs.push_back(truth.fields[field]);
    REQUIRE(block.block->write(outputs, stored));
    Eigen::Vector3d delta;
    block.block->minus(stored, {engine_.state() + block.stored_offset, block.declaration().stored_size}, delta);
    const Eigen::Matrix3d P = engine_.covariance().as().block(block.first, block.first, 3, 3);
    nees.add(truth.t, delta.dot(P.ldlt().solve(delta)));
  }

  internal::filter::Engine& engine_;
  std::shared_ptr<const score::ScorePlan> scored_;
  const internal::filter::FilterPlan& plan_;
  const score::ReferencePlan* reference_ = nullptr;
};

struct Consistency {
  Share nees, nis;
};

Consistency consistency_of(const std::string& name, const std::vector<std::string>& sets, int runs) {
  const auto composition = load(sets);
  score::run(composition);  // opens its sources
  internal::runtime::Runtime runtime(composition->plan());
  Watch watch(runtime, *composition);
  for (int run = 0; run < runs; ++run) {
    runtime.reset(seed, run);
    while (runtime.next_instant()) {
    }
    runtime.finish();
    REQUIRE_FALSE(runtime.engine(0).broken());
  }
  const Consistency found{{watch.nees, 3, runs}, {watch.nis, 5, runs}};
  std::printf("%-32s %3d runs: NEES %6.2f of 3, %5.1f %% of epochs in the 99 %% band; NIS %5.3f of 5, %5.1f %%\n",
              name.c_str(), runs, found.nees.mean, 100 * found.nees.share, found.nis.mean, 100 * found.nis.share);
  std::fflush(stdout);
  return found;
}

const std::string once = R"(/filters/align/measurements/match/update="ekf")";
const std::string iterated = R"(/filters/align/measurements/match/update="iterated")";
const std::string by_points = R"(/filters/align/propagation="unscented")";

}  // namespace

TEST_CASE("paper 000 from a degree: one linearization of the first sample is not consistent") {
  const Consistency ekf = consistency_of("ekf", {once}, 30);
  CHECK(ekf.nees.mean > 4);
  CHECK(ekf.nees.share < 0.1);
  // The propagation has no part in it.
  const Consistency points = consistency_of("ekf, unscented propagation", {once, by_points}, 30);
  CHECK(points.nees.mean > 0.7 * ekf.nees.mean);
  CHECK(points.nees.share < 0.1);
}

TEST_CASE("paper 000 from a degree: iterated it is consistent") {
  const Consistency found = consistency_of("iterated", {iterated}, 100);
  CHECK(found.nees.share >= 0.97);
  CHECK(found.nis.share >= 0.97);
}

TEST_CASE("paper 000 from a degree: iterated and propagated by sigma points it is consistent too") {
  const Consistency found = consistency_of("iterated, unscented propagation", {iterated, by_points}, 100);
  CHECK(found.nees.share >= 0.97);
  CHECK(found.nis.share >= 0.97);
}

}  // namespace alignment_start_test
