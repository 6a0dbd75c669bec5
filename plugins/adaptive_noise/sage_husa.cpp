// SPDX-License-Identifier: Apache-2.0
// R as a mean of innovations that forgets (Sage and Husa).
#include "sage_husa.hpp"

#include <algorithm>

namespace binnacle::adaptive_noise {

struct SageHusa::Row {
  double variance;
  double weight;     // of all samples so far, the nominal one included: 1 + b + b² + …; 0: new
  double is_learnt;  // the sample at hand is to be learnt from
};

ComponentSpec SageHusa::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "sage_husa";
  spec.summary = "R as a mean of innovations or residuals with exponential forgetting";
  spec.source =
      "A. P. Sage and G. W. Husa, Adaptive filtering with unknown prior statistics, Joint Automatic Control Conference "
      "1969; "
      "with fading memory as commonly used";
  spec.parameters = {
      number("forgetting", "1").above(0).at_most(1).defaults("0.98").about("forgetting factor b; 1: no forgetting"),
      choice("from", {"innovation", "residual"})
          .defaults("\"innovation\"")
          .about("source of R: innovations, r^2 - HP-H', which may become negative, or residuals after the update, e^2 "
                 "+ HP+H', which may not"),
      learn_below_parameter(),
  };
  for (ParameterSpec& bound : bounds_parameters("0.1")) spec.parameters.push_back(std::move(bound));
  spec.example = R"({ "forgetting": 0.98, "floor": 0.2, "ceiling": 10 })";
  return spec;
}

SageHusa::SageHusa(const Binding& binding, const NoiseBinding& noise)
    : rows_(declaration_, noise, sizeof(Row) / sizeof(double)),
      forgetting_(binding.parameters().number("forgetting")),
      learn_below_(binding.parameters().number("learn_below")),
      bounds_(read_bounds(binding.parameters())),
      is_residual_(binding.parameters().text("from") == "residual"),
      variances_(declaration_.keeps_array<double>(static_cast<std::size_t>(rows_.max_rows()))) {
  if (is_residual_) declaration_.wants_after();
}

SageHusa::Row& SageHusa::row_at(const MemoryView& memory, int row) const noexcept {
  return *reinterpret_cast<Row*>(rows_.values(memory, rows_.slot(memory, row)).data());
}

// d = 1/(1 + b + … + b^k) = (1 − b)/(1 − b^(k+1)), and 1/(k + 1) for b = 1.
void SageHusa::learn(Row& row, double variance) const noexcept {
  row.weight = forgetting_ * row.weight + 1.0;
  row.variance += (variance - row.variance) / row.weight;
}

void SageHusa::estimate(const Innovation& in, MatrixView R) const {
  const MemoryView& memory = in.memory;
  rows_.enter(in);
  const std::span<double> variance = memory[variances_];
  for (int i = 0; i < in.rows; ++i) {
    Row& row = row_at(memory, i);
    const double nominal = R(i, i), predicted = in.HPHt(i, i);
    if (row.weight == 0.0) row = {nominal, 1.0, 0.0};
    row.is_learnt = predicted <= learn_below_ * nominal ? 1.0 : 0.0;
    if (!is_residual_ && row.is_learnt != 0.0) learn(row, in.residual[i] * in.residual[i] - predicted);
    variance[static_cast<std::size_t>(i)] = bounds_.clamped(row.variance, nominal);
  }
  set_variances(variance.data(), R);
}

void SageHusa::after(const AfterUpdate& in) const {
  if (in.outcome != Outcome::accepted) return;
  for (int i = 0; i < rows_.rows(in.memory); ++i) {
    Row& row = row_at(in.memory, i);
    if (row.is_learnt != 0.0) learn(row, in.residual[i] * in.residual[i] + in.HPHt(i, i));
  }
}

}  // namespace binnacle::adaptive_noise
