// SPDX-License-Identifier: Apache-2.0
#include "response.hpp"

#include <bit>
#include <cmath>

#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;

Response::Response(const FilterInfo& filter) : n_(filter.dof), stored_size_(filter.stored_size) {
  std::size_t size = 2 * as_size(n_ * n_);
  for (const MeasurementInfo& measurement : filter.measurements) {
    of_measurement_.push_back(size);
    max_rows_.push_back(measurement.max_rows);
    size += as_size(measurement.max_rows * measurement.max_rows);
  }
  noise_.resize(size);
  size_.resize(size);
}

/// FNV-1a of their bits.
void Response::take(const double* numbers, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) path_ = (path_ ^ std::bit_cast<std::uint64_t>(numbers[i])) * 1099511628211u;
}

void Response::take(ConstMatrixView A) {
  for (int j = 0; j < A.cols; ++j) take(&A(0, j), as_size(A.rows));
}

void Response::add(ConstMatrixView A, std::size_t at, int ld) {
  for (int j = 0; j < A.cols; ++j)
    for (int i = 0; i < A.rows; ++i) {
      noise_[at + as_size(i + ld * j)] += A(i, j);
      size_[at + as_size(i + ld * j)] += std::sqrt(std::abs(A(i, i) * A(j, j)));
    }
}

void Response::started(Time, const double* x, ConstMatrixView P) {
  take(x, as_size(stored_size_));
  add(P, 0, n_);
}

void Response::stepped(const StepRecord& record) {
  take(record.x1, as_size(stored_size_));
  take(record.Phi);
  add(record.Qd, as_size(n_ * n_), n_);
}

void Response::offered(const UpdateRecord& record) {
  if (!record.R) return;
  const auto m = as_size(record.measurement);
  take(record.residual, as_size(record.rows));
  take(record.H);
  add(record.R, of_measurement_[m], max_rows_[m]);
}

bool differ_in_R(const std::vector<const Response*>& a, const std::vector<const Response*>& b) {
  for (std::size_t k = 0; k < a.size(); ++k)
    for (std::size_t i = a[k]->first_R(); i < a[k]->noise().size(); ++i)
      if (std::abs(b[k]->noise()[i] - a[k]->noise()[i]) > 1e-9 * a[k]->size()[i]) return true;
  return false;
}

Law law_of(const std::vector<const Response*>& once, const std::vector<const Response*>& twice,
           const std::vector<const Response*>& four_times) {
  bool is_there = false, is_square = true, is_linear = true;
  for (std::size_t k = 0; k < once.size(); ++k) {
    if (once[k]->path() != twice[k]->path() || once[k]->path() != four_times[k]->path()) return Law::other;
    for (std::size_t i = 0; i < once[k]->noise().size(); ++i) {
      const double at = once[k]->noise()[i], two = twice[k]->noise()[i] - at, four = four_times[k]->noise()[i] - at;
      const double rounding = 1e-9 * once[k]->size()[i];
      if (std::abs(two) <= rounding && std::abs(four) <= rounding) continue;
      is_there = true;
      // θ² grows by 3 and 15, θ by 1 and 3.
      is_square = is_square && std::abs(four - 5 * two) <= 1e-6 * std::abs(four) + rounding;
      is_linear = is_linear && std::abs(four - 3 * two) <= 1e-6 * std::abs(four) + rounding;
    }
  }
  return !is_there ? Law::none : is_square ? Law::square : is_linear ? Law::linear : Law::curved;
}

}  // namespace binnacle::tune
