// SPDX-License-Identifier: Apache-2.0
#include "record_fields.hpp"
#include "binnacle/state_block.hpp"

#include <utility>

namespace binnacle::python {

namespace {

ConstMatrixView column(const double* numbers, int rows) {
  return numbers ? ConstMatrixView{numbers, rows, 1, rows} : ConstMatrixView{};
}

constexpr Field<StepRecord> of_steps[] = {
    {"x0", true, [](const StepRecord& r, const Sizes& s) { return column(r.x0, s.stored); }},
    {"x1", true, [](const StepRecord& r, const Sizes& s) { return column(r.x1, s.stored); }},
    {"P0", false, [](const StepRecord& r, const Sizes&) { return r.P0; }, Wants::step_covariance},
    {"P1", false, [](const StepRecord& r, const Sizes&) { return r.P1; }, Wants::step_covariance},
    {"Phi", false, [](const StepRecord& r, const Sizes&) { return r.Phi; }, Wants::transition},
    {"Qd", false, [](const StepRecord& r, const Sizes&) { return r.Qd; }, Wants::transition},
};

constexpr Field<UpdateRecord> of_updates[] = {
    {"residual", true, [](const UpdateRecord& r, const Sizes&) { return column(r.residual, r.rows); }},
    {"S", false, [](const UpdateRecord& r, const Sizes&) { return r.S; }},
    {"R", false, [](const UpdateRecord& r, const Sizes&) { return r.R; }},
    {"H", false, [](const UpdateRecord& r, const Sizes&) { return r.H; }, Wants::jacobian},
    {"K", false, [](const UpdateRecord& r, const Sizes&) { return r.K; }},
    {"delta", true, [](const UpdateRecord& r, const Sizes& s) { return column(r.delta, s.rows_of_P); }},
    {"update_residual", true, [](const UpdateRecord& r, const Sizes&) { return column(r.update_residual, r.rows); }},
    {"update_S", false, [](const UpdateRecord& r, const Sizes&) { return r.update_S; }},
    {"x0", true, [](const UpdateRecord& r, const Sizes& s) { return column(r.x0, s.stored); }},
    {"x1", true, [](const UpdateRecord& r, const Sizes& s) { return column(r.x1, s.stored); }},
    {"P0", false, [](const UpdateRecord& r, const Sizes&) { return r.P0; }, Wants::update_covariance},
    {"P1", false, [](const UpdateRecord& r, const Sizes&) { return r.P1; }, Wants::update_covariance},
    {"reset", false, [](const UpdateRecord& r, const Sizes&) { return r.reset; }, Wants::reset},
};

constexpr Field<InflationRecord> of_inflations[] = {
    {"variances", true, [](const InflationRecord& r, const Sizes& s) { return column(r.variances, s.rows_of_P); }},
    {"scales", true, [](const InflationRecord& r, const Sizes& s) { return column(r.scales, s.rows_of_P); }},
    {"P0", false, [](const InflationRecord& r, const Sizes&) { return r.P0; }, Wants::update_covariance},
    {"P1", false, [](const InflationRecord& r, const Sizes&) { return r.P1; }, Wants::update_covariance},
};

constexpr std::pair<const char*, Wants> wanted[] = {{"step_covariance", Wants::step_covariance},
                                                    {"transition", Wants::transition},
                                                    {"update_covariance", Wants::update_covariance},
                                                    {"jacobian", Wants::jacobian},
                                                    {"reset", Wants::reset}};

}  // namespace

std::span<const Field<StepRecord>> step_fields() { return of_steps; }
std::span<const Field<UpdateRecord>> update_fields() { return of_updates; }
std::span<const Field<InflationRecord>> inflation_fields() { return of_inflations; }

void append(ConstMatrixView numbers, std::vector<double>& into) {
  for (int i = 0; i < numbers.rows; ++i)
    for (int j = 0; j < numbers.cols; ++j) into.push_back(numbers(i, j));
}

py::object copied(ConstMatrixView numbers, bool is_vector) {
  if (!numbers) return py::none();
  std::vector<double> copy;
  copy.reserve(static_cast<std::size_t>(numbers.rows) * static_cast<std::size_t>(numbers.cols));
  append(numbers, copy);
  if (is_vector) return to_array(std::move(copy));
  return to_array(std::move(copy), {numbers.rows, numbers.cols});
}

Wants wants_of(const std::vector<std::string>& names) {
  Wants all = Wants::nothing;
  for (const auto& name : names) {
    bool is_known = false;
    for (const auto& [known, wants] : wanted)
      if (name == known) {
        all = all | wants;
        is_known = true;
      }
    if (is_known) continue;
    std::string message = "'" + name + "' is nothing to want of a step log; there are";
    for (const auto& [known, wants] : wanted) message += std::string(known == wanted[0].first ? " " : ", ") + known;
    throw py::value_error(message);
  }
  return all;
}

std::vector<std::string> rows_of_P(const FilterInfo& filter) {
  std::vector<std::string> names;
  for (const auto& block : filter.blocks)
    for (const int component : block.active)
      names.push_back(block.name + "." + block.declaration->error[static_cast<std::size_t>(component)].name);
  return names;
}

}  // namespace binnacle::python
