// SPDX-License-Identifier: Apache-2.0
#include "robust_noise.hpp"

#include <string>
#include <utility>

namespace binnacle::robust {

namespace {

ComponentSpec spec_of(const char* type, const char* summary, const char* source, ParameterSpec constant) {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = type;
  spec.summary = summary;
  spec.source = source;
  spec.parameters = {
      choice("of", {"innovation", "residual"})
          .defaults("\"innovation\"")
          .about("whitened residual: the innovation, by H P- H' + R/w; or the residual after the update, by the "
                 "nominal R"),
      choice("by", {"sample", "part", "key", "row"})
          .defaults("\"sample\"")
          .about("rows that share one weight: all of a sample, those of a group (a part of a stack), those of a key, "
                 "or none"),
      number("efficiency", "1")
          .at_least(0.5)
          .at_most(0.9999)
          .about("efficiency: share of an update's information that remains with the weights under Gaussian noise, or "
                 "more if the prior is large; default: 0.95 unless the constant is given"),
      std::move(constant),
      integer("iterations")
          .at_least(1)
          .at_most(10000)
          .defaults("100")
          .about("largest number of iterations; a note reports when it is reached"),
      number("tolerance", "1").above(0).defaults("1e-6").about("relative tolerance of a weight"),
  };
  spec.example = R"({ "by": "row" })";
  return spec;
}

ParameterSpec constant(const char* name, std::string about) {
  return parameter::number(name, "1").above(0).about(std::move(about) + "; default: from the efficiency");
}

Unit unit_of(const std::string& by) {
  return by == "sample" ? Unit::sample : by == "part" ? Unit::part : by == "key" ? Unit::key : Unit::row;
}

/// In place of the efficiency; by Loss.
constexpr const char* own_constants[] = {"threshold", "scale", "dof", "phi"};

}  // namespace

RobustNoise::RobustNoise(Loss loss, const Binding& binding, const NoiseBinding& noise) {
  const char* const constant = own_constants[static_cast<std::size_t>(loss)];
  const Parameters& parameters = binding.parameters();
  method_.loss = loss;
  method_.unit = unit_of(parameters.text("by"));
  method_.of = parameters.text("of") == "residual" ? Whitened::residual : Whitened::innovation;
  method_.iterations = static_cast<int>(parameters.integer("iterations"));
  method_.tolerance = parameters.number("tolerance");
  if (parameters.has(constant) && parameters.has("efficiency"))
    throw ComponentError("the efficiency gives the '" + std::string(constant) + "': give only one of them",
                         "/" + std::string(constant));
  const double efficiency = parameters.has("efficiency") ? parameters.number("efficiency") : 0.95;
  const int largest = method_.unit == Unit::row ? 1 : noise.max_rows;
  for (int m = 1; m <= largest; ++m)
    method_.tuning.push_back(parameters.has(constant) ? parameters.number(constant)
                                                      : tuning_of(loss, method_.of, efficiency, m));
  constexpr int few = 6;
  for (int m = 1; m <= largest; ++m)
    if (m <= few || m == largest)
      binding.figure(std::string(constant) + " of " + std::to_string(m) + (m == 1 ? " row" : " rows"),
                     method_.tuning[static_cast<std::size_t>(m - 1)], "1");
  rows_ = declaration_.judged_by_nominal().keeps_array<Row>(static_cast<std::size_t>(noise.max_rows));
}

void RobustNoise::estimate(const Innovation& in, MatrixView R) const {
  const auto rows = in.memory[rows_].first(static_cast<std::size_t>(in.rows));
  const Findings findings = write_weighted(method_, in, rows, R);
  if (!findings.has_converged) in.notes.leave("the weights have not converged within `iterations`; the last were used");
  if (findings.is_at_least) in.notes.leave("a weight is at its minimum, 1e-12: an extreme outlier");
  if (findings.is_held) in.notes.leave("R of rows that share a weight is singular: they keep the weight 1");
}

template <>
ComponentSpec Huber::spec() {
  return spec_of("huber", "R/w, where a residual of d > k sigma has the weight w = k/d (Huber's loss)",
                 "P. J. Huber, Robust estimation of a location parameter, Annals of Mathematical Statistics 35, 1964",
                 constant("threshold", "norm k of a whitened residual beyond which its weight decreases"));
}

template <>
ComponentSpec Cauchy::spec() {
  return spec_of("cauchy", "R/w with the weight w = 1/(1 + d^2/c^2) (Cauchy's loss)",
                 "P. W. Holland and R. E. Welsch, Robust regression using iteratively reweighted least-squares, "
                 "Communications in Statistics A6, 1977",
                 constant("scale", "norm c of a whitened residual at which its weight is 1/2"));
}

template <>
ComponentSpec StudentT::spec() {
  return spec_of("student_t", "R/w with the weight w = (nu + m)/(nu + d^2) (likelihood of Student's t)",
                 "K. L. Lange, R. J. A. Little and J. M. G. Taylor, Robust statistical modeling using the t "
                 "distribution, Journal of the American Statistical Association 84, 1989",
                 constant("dof", "degrees of freedom nu"));
}

template <>
ComponentSpec DynamicCovarianceScaling::spec() {
  return spec_of("dcs", "R/w with the weight w = min(1, 2 Phi/(Phi + d^2))^2 (dynamic covariance scaling)",
                 "P. Agarwal, G. D. Tipaldi, L. Spinello, C. Stachniss and W. Burgard, Robust map optimization using "
                 "dynamic covariance scaling, ICRA 2013",
                 constant("phi", "squared norm Phi of a whitened residual beyond which its weight decreases"));
}

}  // namespace binnacle::robust
