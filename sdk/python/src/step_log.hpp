// SPDX-License-Identifier: Apache-2.0
// StepLog: the whole step log of a filter in memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "record_fields.hpp"

namespace binnacle::python {

/// Numbers of several records one behind the other; a record may have any number of them.
struct Ragged {
  std::vector<double> numbers;
  std::vector<std::int64_t> ends;

  void add(ConstMatrixView of_record) {
    if (of_record) append(of_record, numbers);
    ends.push_back(static_cast<std::int64_t>(numbers.size()));
  }
  void pop() {
    ends.pop_back();
    numbers.resize(ends.empty() ? 0 : static_cast<std::size_t>(ends.back()));
  }
};

/// What a late sample voids is taken out again.
class StepLog final : public StepObserver {
 public:
  StepLog(const FilterInfo& filter, Wants wants);

  Wants wants() const override { return wants_; }
  void started(Time t, const double* x, ConstMatrixView P) override;
  void restored(Time t, const double* x, ConstMatrixView P) override { started(t, x, P); }
  void rewound(Time t) override;
  void stepped(const StepRecord& record) override;
  void offered(const UpdateRecord& record) override;
  void inflated(const InflationRecord& record) override;

  /// Its vectors move into the arrays of a dict. Holds the GIL.
  py::dict taken();

 private:
  enum class Kind : std::int8_t { start, step, update, inflation };
  struct Refusal {
    Time t;
    std::int32_t measurement;
    std::int8_t outcome;
    std::string reason;
  };
  void pop();

  const FilterInfo& filter_;
  Sizes sizes_;
  Wants wants_;
  std::vector<std::int8_t> kinds_;         // of all records, in order
  std::vector<Time> times_;                // at which each was made: the end of a step
  std::vector<Time> t0_;                   // of steps
  std::vector<std::int32_t> measurement_;  // of updates
  std::vector<std::int8_t> outcome_;
  std::vector<std::string> reason_;
  std::vector<std::int32_t> rows_;
  std::vector<double> nis_;
  std::vector<std::int32_t> opened_by_;               // of inflations: the measurement
  std::vector<Ragged> starts_;                        // x, P
  std::vector<Ragged> steps_, updates_, inflations_;  // by field
};

}  // namespace binnacle::python
