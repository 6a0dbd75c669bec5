// SPDX-License-Identifier: Apache-2.0
// A target of which only the bearing is measured, its start drawn from P0 in every run: what each way to update makes of it. NEES
// of the whole state, averaged over the runs, after every bearing.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>

#include "catch.hpp"
#include "run/runtime.hpp"
#include "score/run.hpp"

namespace bearing_test {

using namespace binnacle;

namespace {

constexpr int runs = 200, dof = 4;
constexpr double beyond_reason = 23.5;  // chi-square of 4: one in ten thousand

struct Series {
  std::vector<double> nees;  // mean over the runs, by epoch
  double rms_position = 0;   // at the end, m
  int lost = 0;              // runs whose NEES is beyond reason at the end
  double linearizations = 0;
  std::int64_t not_converged = 0, samples = 0, linearized = 0;
};

Series monte_carlo(const std::string& update, std::uint64_t seed) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = {"/filters/track/measurements/sonar/update=" + update};
  const auto composition = score::load(BINNACLE_TEST_PROJECT "/configs/updates/bearing.json", options);
  internal::runtime::Runtime runtime(composition->plan());
  Series series;
  std::vector<double> sums, squares;
  std::size_t epoch = 0;
  double newest = 0;
  int truth = -1;
  for (std::size_t c = 0; c < composition->channels().size(); ++c)
    if (composition->channels()[c].name == "ship.truth") truth = static_cast<int>(c);
  runtime.subscribe([&](int channel, const SampleView& sample) {
    if (channel != truth) return;
    const auto& engine = runtime.engine(0);
    REQUIRE(engine.status().t == sample.t);
    const Eigen::Vector4d d =
        Eigen::Map<const Eigen::Vector4d>(sample.fields) - Eigen::Map<const Eigen::Vector4d>(engine.state());
    const Eigen::Matrix4d P = engine.covariance().as();
    if (sums.size() <= epoch) sums.push_back(0), squares.push_back(0);
    newest = d.dot(P.ldlt().solve(d));
    sums[epoch] += newest / runs;
    squares[epoch] += d.head<2>().squaredNorm() / runs;
    ++epoch;
  });
  for (int run = 0; run < runs; ++run) {
    runtime.reset(seed, run);
    epoch = 0;
    while (runtime.next_instant()) {
    }
    runtime.finish();
    REQUIRE_FALSE(runtime.engine(0).broken());
    series.lost += newest > beyond_reason;
    const auto& tally = runtime.engine(0).ledger().tally(0);
    REQUIRE(tally.by_outcome[static_cast<int>(Outcome::accepted)] == tally.offered);
    series.linearizations += static_cast<double>(tally.iterations);
    series.not_converged += tally.not_converged;
    series.linearized += tally.linearized;
    series.samples += tally.offered;
  }
  series.nees = sums;
  series.rms_position = std::sqrt(squares.back());
  return series;
}

double share_in_band(const Series& series) {
  const boost::math::chi_squared all(dof * runs);
  const double low = boost::math::quantile(all, 0.005) / runs, high = boost::math::quantile(all, 0.995) / runs;
  const auto inside = std::ranges::count_if(series.nees, [&](double nees) { return low <= nees && nees <= high; });
  return static_cast<double>(inside) / static_cast<double>(series.nees.size());
}

}  // namespace

TEST_CASE("of a target's bearing alone, at least one way to update is consistent where the extended filter is not") {
  const std::vector<std::pair<std::string, std::string>> ways = {{"ekf", R"("ekf")"},
                                                                 {"iterated", R"({"type": "iterated", "max": 20})"},
                                                                 {"unscented", R"("unscented")"}};
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    std::vector<Series> all;
    for (const auto& [name, update] : ways) all.push_back(monte_carlo(update, seed));
    std::printf("\nNEES of the whole state (4), mean of %d runs (seed %d), after the bearing at\n  t [s]    ", runs,
                static_cast<int>(seed));
    for (const auto& [name, update] : ways) std::printf("%12s", name.c_str());
    for (std::size_t e = 0; e < all[0].nees.size(); e += e < 5 ? 1 : 5) {
      std::printf("\n  %5.0f    ", 50.0 * static_cast<double>(e));
      for (const auto& series : all) std::printf("%12.2f", series.nees[e]);
    }
    std::printf("\n  in band  ");
    for (const auto& series : all) std::printf("%10.1f %%", 100 * share_in_band(series));
    std::printf("\n  lost runs");
    for (const auto& series : all) std::printf("%12d", series.lost);
    std::printf("\n  RMS [m]  ");
    for (const auto& series : all) std::printf("%12.1f", series.rms_position);
    std::printf("\n  iterated: %.2f linearizations a bearing, %d of %d did not converge; unscented: %d linearized\n",
                all[1].linearizations / static_cast<double>(all[1].samples), static_cast<int>(all[1].not_converged),
                static_cast<int>(all[1].samples), static_cast<int>(all[2].linearized));
    CHECK(share_in_band(all[0]) < 0.95);
    CHECK(std::max(share_in_band(all[1]), share_in_band(all[2])) >= 0.95);
  }
}

}  // namespace bearing_test
