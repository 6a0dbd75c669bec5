// SPDX-License-Identifier: Apache-2.0
// R = R1 + β R2, with β fitted to the residuals of a window (paper 000).
#include "beta_adapter.hpp"

#include <algorithm>
#include <string>

namespace binnacle::adaptive_noise {

/// Sums over the rows that share a β, and what is remembered of it.
struct BetaAdapter::Unit {
  double beta, has_beta;                   // remembered
  double wanted, floor, ceiling, nominal;  // tr[(… − R1) R2ᵀ] for M − HP⁻Hᵀ and for bounds and nominal R
  double square;                           // tr[R2 R2ᵀ]
  double is_full;
};

ComponentSpec BetaAdapter::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "beta_adapter";
  spec.summary = "R = R1 + beta R2, with beta fitted to the residuals of a window";
  spec.source =
      "Park and Lee, SDINS transfer alignment using adaptive filter for vertical launcher (paper 000), (9)-(30), "
      "with the division of (19) in (20) and (26)";
  spec.parameters = {
      integer("window").at_least(1).at_most(100000).defaults("25").about(
          "length N of the window in samples of this measurement"),
      choice("per", {"group", "component", "one"})
          .defaults("\"group\"")
          .about("rows that share one beta: those of a group (a part of a stack), none, or all"),
      number("r1_factor", "1")
          .at_least(0)
          .defaults("1e-3")
          .about("standard deviation of R1 as a factor on the nominal one, for groups that r1 does not list"),
      map("r1", number("sigma", "*")).about("standard deviation of R1 by group"),
      map("r2", number("sigma", "*"))
          .about("standard deviation of R2 by group; for groups that are not listed R2 is the nominal R, and beta is a "
                 "factor on it"),
      choice("start", {"nominal", "literal"})
          .defaults("\"nominal\"")
          .about("R before the window is full: the nominal R, or with beta from the first sample as in the paper"),
      boolean("hold").defaults("false").about("keep the last beta if the new one would be negative; default: use zero"),
  };
  for (ParameterSpec& bound : bounds_parameters("0")) spec.parameters.push_back(std::move(bound));
  spec.example = R"({ "window": 25, "start": "nominal", "hold": true })";
  return spec;
}

BetaAdapter::BetaAdapter(const Binding& binding, const NoiseBinding& noise)
    : window_(static_cast<int>(binding.parameters().integer("window"))),
      rows_(declaration_, noise, Window::values(window_.length()), window_.length()),
      r1_(read_variances(binding.parameters(), "r1", noise)),
      r2_(read_variances(binding.parameters(), "r2", noise)),
      r1_factor_(binding.parameters().number("r1_factor")),
      bounds_(read_bounds(binding.parameters())),
      waits_(binding.parameters().text("start") == "nominal"),
      holds_(binding.parameters().boolean("hold")) {
  const std::string& per = binding.parameters().text("per");
  per_ = per == "group" ? Per::group : per == "component" ? Per::component : Per::one;
  units_ = declaration_.keeps_array<Unit>(static_cast<std::size_t>(unit_count()));
  variances_ = declaration_.keeps_array<double>(static_cast<std::size_t>(rows_.max_rows()));
}

/// A group is called by its full name, PART.GROUP in a stack, or by the part's alone.
BetaAdapter::Variances BetaAdapter::read_variances(const Parameters& parameters, const char* name,
                                                   const NoiseBinding& noise) {
  Variances variances(std::max<std::size_t>(noise.groups.size(), 1));
  if (!parameters.has(name)) return variances;
  for (const auto& [key, value] : parameters.members(name)) {
    const std::string pointer = std::string("/") + name + "/" + key;
    bool is_found = false;
    std::string names;
    for (std::size_t g = 0; g < noise.groups.size(); ++g) {
      const NamedUnit& group = noise.groups[g];
      names += (names.empty() ? "" : ", ") + group.name;
      if (key != group.name && key != group.name.substr(0, group.name.find('.'))) continue;
      const bool has_unit = !value.text.empty() && value.text != "1";
      if (has_unit && !group.unit.empty() && value.text != group.unit)
        throw ComponentError("group '" + group.name + "' is in " + group.unit + ", not in " + value.text, pointer);
      if (!(value.number > 0.0)) throw ComponentError("must be above 0", pointer);
      variances[g] = value.number * value.number;
      is_found = true;
    }
    if (!is_found) throw ComponentError("no group is called '" + key + "'; there are: " + names, pointer);
  }
  return variances;
}

int BetaAdapter::unit_count() const noexcept {
  return per_ == Per::one ? 1 : per_ == Per::group ? rows_.groups() : rows_.slots();
}

int BetaAdapter::unit_of(const MemoryView& memory, int row) const noexcept {
  return per_ == Per::one ? 0 : per_ == Per::group ? rows_.group(memory, row) : rows_.slot(memory, row);
}

void BetaAdapter::estimate(const Innovation& in, MatrixView R) const {
  const MemoryView& memory = in.memory;
  rows_.enter(in);
  window_.clear_place(rows_, memory);
  const std::span<Unit> unit = memory[units_];
  for (Unit& sum : unit) sum = {sum.beta, sum.has_beta, 0, 0, 0, 0, 0, 1};

  const auto r1 = [&](int row) {
    return r1_[static_cast<std::size_t>(rows_.group(memory, row))].value_or(r1_factor_ * r1_factor_ * R(row, row));
  };
  const auto r2 = [&](int row) {
    return r2_[static_cast<std::size_t>(rows_.group(memory, row))].value_or(R(row, row));
  };

  for (int row = 0; row < in.rows; ++row) {
    const int slot = rows_.slot(memory, row);
    window_.push(rows_, slot, in.residual[row], memory);
    const std::span<const double> past = rows_.values(memory, slot);
    Unit& sum = unit[static_cast<std::size_t>(unit_of(memory, row))];
    if (per_ == Per::component && past.back() == 1.0) sum.has_beta = 0;  // a slot taken over
    const double nominal = R(row, row), floor = bounds_.floor, ceiling = bounds_.ceiling;
    sum.wanted += r2(row) * (window_.mean_product(past, past) - in.HPHt(row, row) - r1(row));
    sum.nominal += r2(row) * (nominal - r1(row));
    sum.floor += r2(row) * (floor * floor * nominal - r1(row));
    sum.ceiling += r2(row) * (ceiling * ceiling * nominal - r1(row));
    sum.square += r2(row) * r2(row);
    if (!window_.is_full(past)) sum.is_full = 0;
  }
  for (Unit& sum : unit) {
    if (!(sum.square > 0.0)) continue;
    if (sum.has_beta == 0.0) sum.beta = std::max(sum.nominal / sum.square, 0.0);
    sum.has_beta = 1;
    if (waits_ && sum.is_full == 0.0) continue;
    const double beta = sum.wanted / sum.square;
    if (beta >= 0.0 || !holds_) sum.beta = std::max(beta, 0.0);
    sum.beta = std::clamp(sum.beta, std::max(sum.floor / sum.square, 0.0), std::max(sum.ceiling / sum.square, 0.0));
  }

  const std::span<double> variance = memory[variances_];
  for (int row = 0; row < in.rows; ++row) {
    const Unit& sum = unit[static_cast<std::size_t>(unit_of(memory, row))];
    const bool is_nominal = !(sum.square > 0.0) || (waits_ && sum.is_full == 0.0);
    variance[static_cast<std::size_t>(row)] = is_nominal ? R(row, row) : r1(row) + sum.beta * r2(row);
  }
  set_variances(variance.data(), R);
}

}  // namespace binnacle::adaptive_noise
