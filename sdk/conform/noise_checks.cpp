// SPDX-License-Identifier: Apache-2.0
// numbers.noise: what an estimator gives is a covariance, and in the end the right one.
#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "fixture.hpp"
#include "guarded.hpp"
#include "miniature.hpp"

namespace binnacle::conform {

namespace {

/// A scalar-by-scalar filter around the estimator: innovations of a known R, post-fit residuals of the R it gives.
class World {
 public:
  World(Trial& trial, double factor) : World(factor, compose_example(trial)) {}
  World(double factor, std::shared_ptr<const Composition> composition)
      : composition_(std::move(composition)),
        part_(parts::noise(*composition_, filter_name, "adapted")),
        caller_(*part_.estimator),
        memory_(caller_.fresh_memory()) {
    nominal_ = Eigen::Vector2d(4, 9);
    true_R_ = factor * nominal_;
  }
  /// One innovation; R as estimated.
  Eigen::Matrix2d step(std::mt19937_64& random, double size = 1) {
    return caller_.estimate(next(random, size), memory_.data()).R;
  }
  testing::Complaints check(std::mt19937_64& random, double size) {
    return check_noise(caller_, next(random, size), memory_.data());
  }
  const Eigen::Vector2d& true_R() const { return true_R_; }
  bool is_judged_by_nominal() const { return part_.estimator->declaration().is_judged_by_nominal; }
  /// R of an innovation of its own, from memory as at the start of a run.
  Eigen::Matrix2d fresh(const Eigen::Vector2d& residual) const {
    auto memory = caller_.fresh_memory();
    testing::InnovationNumbers innovation;
    innovation.residual = residual;
    innovation.HPHt = Eigen::Vector2d(0.5, 0.8).asDiagonal();
    innovation.R_nominal = nominal_.asDiagonal();
    return caller_.estimate(innovation, memory.data()).R;
  }

 private:
  testing::InnovationNumbers next(std::mt19937_64& random, double size) {
    const Eigen::Vector2d M(0.5, 0.8);  // H P- H'
    testing::InnovationNumbers innovation;
    innovation.t = time_ += 100'000'000;
    innovation.residual = size * (M + true_R_).cwiseSqrt().cwiseProduct(normals(random, 2));
    innovation.HPHt = M.asDiagonal();
    innovation.R_nominal = nominal_.asDiagonal();
    return innovation;
  }

  std::shared_ptr<const Composition> composition_;
  parts::NoisePart part_;
  testing::NoiseCaller caller_;
  std::vector<std::byte> memory_;
  Eigen::Vector2d nominal_, true_R_;
  Time time_ = 0;
};

void estimated_covariance(Trial& trial) {
  auto random = trial.random(600);
  World world(trial, 1.0);
  for (int k = 0; k < trial.repeats(200); ++k) {
    // Quiet and loud stretches: the differences M - L of the estimators go through zero.
    const double size = k % 60 < 20 ? 0.0 : k % 60 < 40 ? 30.0 : 1.0;
    const auto complaints = world.check(random, size);
    if (!trial.expect(complaints.empty(), "after ", k + 1, " innovations ", complaints.text())) return;
  }
}

void recovery(Trial& trial) {
  auto random = trial.random(700);
  World world(trial, 1.0);
  if (world.is_judged_by_nominal()) Trial::not_applicable("it weighs each sample by itself, and recovers no R");
  const int settle = 2000, count = trial.repeats(4000);
  for (int k = 0; k < settle; ++k) world.step(random);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (int k = 0; k < count; ++k) sum += world.step(random).diagonal();
  const Eigen::Vector2d ratio = (sum / count).cwiseQuotient(world.true_R());
  // A window of N gives an R with a relative deviation of sqrt(2/N); over `count` samples its mean one of sqrt(2/count),
  // five of which are allowed besides the 10 % that a bound on either side may bias it by.
  const double allowed = 0.10 + 5 * std::sqrt(2.0 / count);
  for (int i = 0; i < 2; ++i)
    trial.expect(std::abs(ratio[i] - 1) < allowed, "row ", i, ": where the true R is the nominal one it settles at ",
                 ratio[i], " of it, allowed 1 +- ", allowed);
}

/// A loss: in whatever direction, the farther an innovation is off, the larger is R.
void outlier(Trial& trial) {
  auto random = trial.random(900);
  World world(trial, 1.0);
  if (!world.is_judged_by_nominal()) Trial::not_applicable("R is what it makes of the past, not of one sample");
  for (int k = 0; k < trial.repeats(20); ++k) {
    const Eigen::Vector2d direction = normals(random, 2).normalized();
    double last = 0, first = 0;
    for (double size = 0.1; size < 1e5; size *= 1.5) {
      const double trace = world.fresh(size * direction).trace();
      if (!trial.expect(trace >= last * (1 - 1e-5), "of an innovation ", size,
                        " sigma off R is smaller than of one less far off: ", trace, " after ", last, " (traces)"))
        return;
      last = trace;
      if (first == 0) first = trace;
    }
    if (!trial.expect(last > 2 * first, "an innovation 1e5 sigma off is trusted as if it were right")) return;
  }
}

/// By convention `floor` and `ceiling` are factors on the nominal standard deviation.
void bounds(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  const auto has = [&](const char* name) {
    return std::any_of(type.spec.parameters.begin(), type.spec.parameters.end(), [&](const ParameterSpec& parameter) {
      return parameter.name == name && parameter.type == ParameterType::number && parameter.unit == "1";
    });
  };
  if (!has("floor") && !has("ceiling")) Trial::not_applicable("it has neither floor nor ceiling");
  Json settings = example_of(type.spec);
  if (has("floor")) settings["floor"] = 0.5;
  if (has("ceiling")) settings["ceiling"] = 2;
  auto random = trial.random(800);
  World world(1.0, compose(trial, miniature(trial, type, catalog, settings)));
  for (int k = 0; k < trial.repeats(600); ++k) {
    const Eigen::Vector2d ratio = world.step(random, k < 300 ? 0.0 : 100.0).diagonal().cwiseQuotient(world.true_R());
    if (has("floor") && !trial.expect(ratio.minCoeff() >= 0.25 * (1 - 1e-9), "with floor 0.5 R falls to ",
                                      ratio.minCoeff(), " of the nominal one, below 0.25"))
      return;
    if (has("ceiling") && !trial.expect(ratio.maxCoeff() <= 4 * (1 + 1e-9), "with ceiling 2 R rises to ",
                                        ratio.maxCoeff(), " of the nominal one, above 4"))
      return;
  }
}

}  // namespace

std::vector<Check> noise_checks() {
  const std::vector<Role> roles = {Role::noise_estimator};
  return {
      check("numbers.noise.covariance", 2, roles, {"life.repeatable"},
            "R is symmetric, positive semidefinite and finite through quiet and loud stretches", estimated_covariance),
      check("numbers.noise.bounds", 3, roles, {"numbers.noise.covariance"},
            "R keeps between floor and ceiling, which are factors on the nominal standard deviation", bounds),
      check("numbers.noise.recovery", 3, roles, {"numbers.noise.covariance"},
            "it recovers a known R from innovations that have it", recovery),
      check("numbers.noise.outlier", 3, roles, {"numbers.noise.covariance"},
            "where it is judged by the nominal R, an innovation that is farther off is trusted no more", outlier),
  };
}

}  // namespace binnacle::conform
