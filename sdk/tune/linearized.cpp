// SPDX-License-Identifier: Apache-2.0
#include "linearized.hpp"

#include <algorithm>
#include <cmath>

#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;

std::vector<std::size_t> Linearized::noise() const {
  std::vector<std::size_t> noise;
  for (std::size_t p = 0; p < laws_.size(); ++p)
    if (is_of_noise(laws_[p])) noise.push_back(p);
  return noise;
}

/// c: of the parameters of noise.
std::vector<double> Linearized::changes(const std::vector<double>& u) const {
  std::vector<double> c;
  for (const std::size_t p : noise()) {
    const Parameter& parameter = plan_.parameters[p];
    c.push_back(law_value(laws_[p], parameter.value_of(u[p])) - law_value(laws_[p], parameter.value_of(u_[p])));
  }
  return c;
}

std::vector<const LinearLog*> Linearized::logs() const {
  std::vector<const LinearLog*> logs;
  for (const MemberRun& run : runs_)
    for (const auto& filter : run.filters) logs.push_back(&filter->log);
  return logs;
}

double Linearized::information(const std::vector<double>& u, Eigen::VectorXd& gradient,
                               Eigen::MatrixXd& information) const {
  const auto c = changes(u);
  const auto logs = this->logs();
  const auto noise = this->noise();
  std::vector<double> values(logs.size());
  std::vector<Eigen::VectorXd> slopes(logs.size());
  std::vector<Eigen::MatrixXd> of_logs(logs.size());
  in_parallel(jobs_, logs.size(), [&](std::size_t k) { values[k] = logs[k]->information(c, slopes[k], of_logs[k]); });
  double sum = 0;
  for (const double value : values) sum += value;
  if (!std::isfinite(sum)) return sum;
  Eigen::VectorXd g(static_cast<Eigen::Index>(noise.size()));
  for (std::size_t i = 0; i < noise.size(); ++i)
    g[static_cast<Eigen::Index>(i)] = law_value(laws_[noise[i]], plan_.parameters[noise[i]].value_of(u[noise[i]]));
  gradient.setZero(g.size());
  information.setZero(g.size(), g.size());
  for (std::size_t k = 0; k < logs.size(); ++k) {
    gradient += g.asDiagonal() * slopes[k];
    information += g.asDiagonal() * of_logs[k] * g.asDiagonal();
  }
  return sum;
}

double Linearized::likelihood(const std::vector<double>& u, double* gradient) const {
  const auto c = changes(u);
  const auto noise = this->noise();
  const auto logs = this->logs();
  std::vector<double> values(logs.size());
  std::vector<std::vector<double>> slopes(logs.size(), std::vector<double>(noise.size()));
  in_parallel(jobs_, logs.size(),
              [&](std::size_t k) { values[k] = logs[k]->likelihood(c, gradient ? slopes[k].data() : nullptr); });
  double sum = 0;
  for (const double value : values) sum += value;
  if (!gradient) return sum;
  std::fill_n(gradient, u.size(), 0.0);
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const std::size_t p = noise[i];
    const Parameter& parameter = plan_.parameters[p];
    for (const auto& of_log : slopes) gradient[p] += of_log[i];
    gradient[p] *= law_slope(laws_[p], parameter, parameter.value_of(u[p]));
  }
  return sum;
}

void Linearized::differences(const std::vector<double>& u, double* gradient) const {
  constexpr double step = 2e-3;
  std::fill_n(gradient, u.size(), 0.0);
  for (std::size_t p = 0; p < u.size(); ++p) {
    if (!is_of_noise(laws_[p])) continue;
    const auto slope = [&](double by) {
      auto above = u, below = u;
      above[p] += by, below[p] -= by;
      return (likelihood(above, nullptr) - likelihood(below, nullptr)) / (2 * by);
    };
    gradient[p] = (4 * slope(step) - slope(2 * step)) / 3;
  }
}

bool Linearized::has_considered() const {
  return std::ranges::any_of(runs_, [](const MemberRun& run) {
    return std::ranges::any_of(run.filters, [](const auto& filter) { return filter->log.has_considered(); });
  });
}

double gradient_error(const Linearized& linearized, const std::vector<double>& u) {
  std::vector<double> sweep(u.size()), differences(u.size());
  linearized.likelihood(u, sweep.data());
  linearized.differences(u, differences.data());
  double worst = 0, largest = 0;
  for (std::size_t p = 0; p < u.size(); ++p) {
    worst = std::max(worst, std::abs(sweep[p] - differences[p]));
    largest = std::max(largest, std::abs(differences[p]));
  }
  return worst / (1 + largest);
}

double prior_cost(const Plan& plan, const std::vector<double>& u, double* gradient) {
  double cost = 0;
  for (std::size_t p = 0; p < u.size(); ++p) {
    const auto& prior = plan.parameters[p].prior;
    if (!prior) continue;
    const double z = (u[p] - prior->mean) / prior->sigma;
    cost += 0.5 * z * z;
    if (gradient) gradient[p] += z / prior->sigma;
  }
  return cost;
}

}  // namespace binnacle::tune
