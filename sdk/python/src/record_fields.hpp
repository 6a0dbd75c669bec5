// SPDX-License-Identifier: Apache-2.0
// The numbers of the step log's records by name: what observers see and what the log keeps.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/step_log.hpp"
#include "convert.hpp"

namespace binnacle::python {

/// Of a filter.
struct Sizes {
  int rows_of_P = 0;
  int stored = 0;
};

template <class Record>
struct Field {
  const char* name;
  bool is_vector;
  /// Null where the record does not have it. A vector is one column.
  ConstMatrixView (*of)(const Record& record, const Sizes& sizes);
  Wants wants = Wants::nothing;  // what it is computed for

  /// Null where it is not among what was wanted: for another observer of the filter it may have been computed all the same.
  ConstMatrixView wanted(const Record& record, const Sizes& sizes, Wants all) const {
    return includes(all, wants) ? of(record, sizes) : ConstMatrixView{};
  }
};

std::span<const Field<StepRecord>> step_fields();
std::span<const Field<UpdateRecord>> update_fields();
std::span<const Field<InflationRecord>> inflation_fields();

/// Behind what is in `into`, row by row.
void append(ConstMatrixView numbers, std::vector<double>& into);

/// A copy, (rows,) or (rows, columns); None where it is null.
py::object copied(ConstMatrixView numbers, bool is_vector);

/// `wants` of an observer or a log by name: "step_covariance", "transition", "update_covariance", "jacobian", "reset".
/// Throws ValueError that lists them.
Wants wants_of(const std::vector<std::string>& names);

/// Names of the rows of P: "position.north".
std::vector<std::string> rows_of_P(const FilterInfo& filter);

}  // namespace binnacle::python
