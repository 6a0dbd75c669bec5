// SPDX-License-Identifier: Apache-2.0
// Filters whose model is the truth: NEES and NIS over Monte Carlo runs are those of chi-square, and those of a filter
// that is set wrongly are not.
//
// Errors at one instant are independent between runs but not between instants, so NEES is averaged over the runs at
// instants that were picked beforehand, and all statements about them share one 99 % (Bonferroni). Innovations are
// white, so NIS is averaged over everything. (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking
// and Navigation, 2001, section 5.4.)
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <boost/math/distributions/chi_squared.hpp>

#include "catch.hpp"
#include "plan.hpp"  // of sdk/score
#include "run/runtime.hpp"
#include "score/run.hpp"

namespace consistency_test {

using namespace binnacle;

namespace {

constexpr std::uint64_t seed = 20240501;
constexpr int runs = 60;
constexpr double confidence = 0.99;

/// Climbing and turning have begun; between turns; after all of them; the last fix before the end, at rest.
const std::vector<double> instants = {20, 75, 140, 202};

std::shared_ptr<const Composition> load(const std::string& file, std::vector<std::string> sets = {}) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  options.sets = std::move(sets);
  return score::load(std::string(BINNACLE_TEST_PROJECT "/tests/consistency/") + file, options);
}

/// Where the mean of `count` χ² variables of `dof` each lies with the given probability.
struct Band {
  Band(double dof, double count, double probability) {
    const boost::math::chi_squared distribution(dof * count);
    const double tail = (1 - probability) / 2;
    low = boost::math::quantile(distribution, tail) / count;
    high = boost::math::quantile(boost::math::complement(distribution, tail)) / count;
  }
  bool contains(double value) const { return low <= value && value <= high; }
  double low = 0, high = 0;
};

struct Average {
  double sum = 0;
  int count = 0;
  int dof = 0;
  void add(double value) { sum += value, ++count; }
  double mean() const { return sum / count; }
};

/// NEES of each block and of all together at the picked instants.
class Nees {
 public:
  Nees(internal::runtime::Runtime& runtime, const Composition& composition)
      : runtime_(runtime),
        scored_(score::plan_of(composition)),
        plan_(runtime.plan().filters.front()),
        figures_(instants.size(), std::vector<Average>(plan_.blocks.size() + 1)) {
    for (auto& row : figures_) {
      for (std::size_t b = 0; b < plan_.blocks.size(); ++b)
        row[b].dof = static_cast<int>(plan_.blocks[b].active.size());
      row.back().dof = plan_.n;
    }
    runtime.subscribe([this](int channel, const SampleView& sample) {
      if (channel == scored_->references.front().channel) take(channel, sample);
    });
  }
  Nees(const Nees&) = delete;
  Nees& operator=(const Nees&) = delete;

  std::string name(std::size_t group) const {
    return group < plan_.blocks.size() ? plan_.blocks[group].name : "all together";
  }
  const std::vector<std::vector<Average>>& figures() const { return figures_; }

 private:
  void take(int channel, const SampleView& truth) {
    for (std::size_t i = 0; i < instants.size(); ++i)
      if (truth.t == nanoseconds(instants[i])) add(figures_[i], channel, truth);
  }
  void add(std::vector<Average>& row, int channel, const SampleView& truth) {
    internal::filter::Engine& engine = runtime_.engine(0);
    REQUIRE(engine.status().t == truth.t);
    const Eigen::MatrixXd P = engine.covariance().as();
    Eigen::VectorXd delta = Eigen::VectorXd::Constant(plan_.n, std::numeric_limits<double>::quiet_NaN());
    for (const auto& reference : scored_->references) {
      REQUIRE(reference.channel == channel);
      const auto& block = plan_.blocks[static_cast<std::size_t>(reference.block)];
      std::vector<double> outputs;
      for (const int field : reference.fields) outputs.push_back(truth.fields[field]);
      std::vector<double> stored(static_cast<std::size_t>(block.declaration().stored_size));
      REQUIRE(block.block->write(outputs, stored));
      block.block->minus(stored, {engine.state() + block.stored_offset, block.declaration().stored_size},
                         {delta.data() + block.first, block.dof()});
    }
    for (std::size_t b = 0; b < plan_.blocks.size(); ++b) {
      const int first = plan_.blocks[b].first, dof = row[b].dof;
      row[b].add(nees(delta.segment(first, dof), P.block(first, first, dof, dof)));
    }
    row.back().add(nees(delta, P));
  }

  static double nees(const Eigen::VectorXd& delta, const Eigen::MatrixXd& P) {
    const Eigen::LLT<Eigen::MatrixXd> factor(P);
    REQUIRE(factor.info() == Eigen::Success);
    return delta.dot(factor.solve(delta));
  }

  internal::runtime::Runtime& runtime_;
  std::shared_ptr<const score::ScorePlan> scored_;
  const internal::filter::FilterPlan& plan_;
  std::vector<std::vector<Average>> figures_;
};

/// What a Monte Carlo found: how many of the statements about NEES hold, and whether the one about NIS does.
struct Consistency {
  int nees_statements = 0;
  int nees_outside = 0;
  double nis = 0;  // mean, over the rows of a fix
  double nis_dof = 0;
  bool nis_is_inside = false;
};

void run_to_the_end(internal::runtime::Runtime& runtime, int run) {
  runtime.reset(seed, run);
  while (runtime.next_instant()) {
  }
  runtime.finish();
}

Consistency monte_carlo(const std::string& title, const std::shared_ptr<const Composition>& composition) {
  score::run(composition);  // opens its sources
  internal::runtime::Runtime runtime(composition->plan());
  Nees nees(runtime, *composition);
  double nis_sum = 0, nis_count = 0, dof_sum = 0;
  for (int run = 0; run < runs; ++run) {
    run_to_the_end(runtime, run);
    const internal::filter::Engine& engine = runtime.engine(0);
    REQUIRE_FALSE(engine.broken());
    const auto& ledger = engine.ledger().tally(0);
    REQUIRE(ledger.by_outcome[static_cast<int>(Outcome::accepted)] == ledger.offered);
    nis_sum += ledger.nis_sum;
    nis_count += static_cast<double>(ledger.nis_count);
    dof_sum += static_cast<double>(ledger.rows_used);
  }

  Consistency found;
  found.nees_statements = static_cast<int>(instants.size() * nees.figures().front().size());
  const double each = 1 - (1 - confidence) / found.nees_statements;
  std::printf("\n%s: %d runs\n  %-14s dof  band            ", title.c_str(), runs, "mean NEES");
  for (const double t : instants) std::printf("%7.0f s", t);
  for (std::size_t group = 0; group < nees.figures().front().size(); ++group) {
    const int dof = nees.figures().front()[group].dof;
    const Band band(dof, runs, each);
    std::printf("\n  %-14s %3d  %6.2f … %6.2f ", nees.name(group).c_str(), dof, band.low, band.high);
    for (const auto& row : nees.figures()) {
      REQUIRE(row[group].count == runs);
      const bool is_inside = band.contains(row[group].mean());
      if (!is_inside) ++found.nees_outside;
      std::printf("%8.2f%c", row[group].mean(), is_inside ? ' ' : '*');
    }
  }
  found.nis = nis_sum / nis_count;
  found.nis_dof = dof_sum / nis_count;
  const Band band(found.nis_dof, nis_count, confidence);
  found.nis_is_inside = band.contains(found.nis);
  std::printf("\n  mean NIS       %3.0f  %6.3f … %6.3f  %8.3f%c  (%.0f fixes; * outside)\n", found.nis_dof, band.low,
              band.high, found.nis, found.nis_is_inside ? ' ' : '*', nis_count);
  return found;
}

/// Settings of matched.json with Q of the strapdown, or R of the fix, so many times what it is.
std::vector<std::string> process_noise(double factor) {
  const std::string strapdown = "/filters/ins/process/strapdown/";
  return {strapdown + "gyro_noise=" + std::to_string(0.3 * std::sqrt(factor)) + " deg/sqrt(h)",
          strapdown + "accel_noise=" + std::to_string(0.05 * std::sqrt(factor)) + " m/s/sqrt(h)"};
}
std::vector<std::string> fix_noise(double factor) {
  const std::string stack = "/filters/ins/measurements/fix/stack/";
  const std::string scale = "/scale=" + std::to_string(std::sqrt(factor));
  return {stack + "position" + scale, stack + "velocity" + scale};
}

}  // namespace

TEST_CASE("NEES and NIS of a filter whose model is the truth: constant biases") {
  const Consistency found = monte_carlo("matched, constant biases", load("matched.json"));
  CHECK(found.nees_outside == 0);
  CHECK(found.nis_is_inside);
}

TEST_CASE("NEES and NIS of a filter whose model is the truth: wandering biases") {
  const Consistency found = monte_carlo("matched, Gauss-Markov biases", load("matched_drift.json"));
  CHECK(found.nees_outside == 0);
  CHECK(found.nis_is_inside);
}

TEST_CASE("NEES and NIS of a filter whose model is the truth, in the forms that keep a factor of P") {
  const std::string form = GENERATE("ud", "square_root");
  const Consistency found =
      monte_carlo("matched, constant biases, " + form, load("matched.json", {"/filters/ins/covariance=" + form}));
  CHECK(found.nees_outside == 0);
  CHECK(found.nis_is_inside);
}

// NIS hardly sees the process noise of an inertial sensor: the fixes' own noise covers it. NEES does.
TEST_CASE("a filter with twice the process noise is found out") {
  const Consistency found = monte_carlo("process noise x 2", load("matched.json", process_noise(2)));
  CHECK(found.nees_outside > 0);
  CHECK(found.nis < found.nis_dof);
}

TEST_CASE("a filter with half the process noise is found out") {
  const Consistency found = monte_carlo("process noise / 2", load("matched.json", process_noise(0.5)));
  CHECK(found.nees_outside > 0);
  CHECK(found.nis > found.nis_dof);
}

TEST_CASE("a filter that believes its fixes too little is found out") {
  const Consistency found = monte_carlo("R x 1.5", load("matched.json", fix_noise(1.5)));
  CHECK(found.nees_outside > 0);
  CHECK_FALSE(found.nis_is_inside);
}

TEST_CASE("a run's summary has the NEES and NIS of that run") {
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const double t = instants[i];
    const auto composition = load("matched.json", {"/evaluate/after=" + std::to_string(t - 0.5),
                                                   "/evaluate/until=" + std::to_string(t + 0.5)});
    const auto summary = score::run(composition, {seed, 7}).summary["filters"]["ins"];
    internal::runtime::Runtime runtime(composition->plan());
    const Nees nees(runtime, *composition);
    run_to_the_end(runtime, 7);
    const auto& row = nees.figures()[i];
    for (std::size_t group = 0; group < row.size(); ++group) {
      const bool is_state = group + 1 == row.size();
      const auto& reported = summary["consistency"][is_state ? "state" : nees.name(group)];
      CAPTURE(t, nees.name(group), reported["nees_mean"].get<double>(), row[group].mean());
      CHECK(reported["n"] == 1);
      CHECK(reported["dof"] == row[group].dof);
      CHECK(std::abs(reported["nees_mean"].get<double>() / row[group].mean() - 1) < 1e-9);
    }
    const auto& ledger = runtime.engine(0).ledger().tally(0);
    const auto& reported = summary["measurements"]["fix"];
    CHECK(reported["accepted"] == ledger.nis_count);
    CHECK(reported["nis_mean"].get<double>() == ledger.nis_sum / static_cast<double>(ledger.nis_count));
  }
}

}  // namespace consistency_test
