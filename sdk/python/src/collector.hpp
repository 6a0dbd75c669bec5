// SPDX-License-Identifier: Apache-2.0
// Collector: what a run records, kept in memory as results::RunWriter keeps it in run.nc.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "results/results.hpp"
#include "score/run.hpp"

namespace binnacle::python {

/// Estimates of one filter: a row per record.
struct Records {
  std::string name;
  std::vector<score::RecordColumn> columns;  // outputs, then their 1-sigma
  std::vector<Time> t;
  std::vector<double> values;  // row by row
};

/// Asked now and then whether the run goes on; throws where it does not.
using GoesOn = std::function<void()>;

class Collector : public score::RunObserver {
 public:
  /// keeps_records: reading estimates costs more than a filter step.
  Collector(const Composition& composition, bool keeps_records, bool keeps_updates, GoesOn goes_on);

  bool wants_records() const override { return keeps_records_; }
  void begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns) override;
  void record(int filter, Time t, std::span<const double> values) override;
  StepObserver* step_observer(int filter) override;
  void scored(int filter, const score::ErrorSeries& errors) override;
  bool progress(Time t) override;

  std::vector<Records>& records() { return records_; }
  /// By filter.
  std::vector<std::vector<results::Error>>& errors() { return errors_; }
  /// By filter and measurement.
  std::vector<std::vector<results::Updates>>& updates() { return updates_; }

 private:
  class Updates : public StepObserver {
   public:
    explicit Updates(std::vector<results::Updates>& into) : into_(&into) {}
    void offered(const UpdateRecord& record) override;

   private:
    std::vector<results::Updates>* into_;
  };

  bool keeps_records_, keeps_updates_;
  GoesOn goes_on_;
  std::vector<Records> records_;
  std::vector<std::vector<results::Error>> errors_;
  std::vector<std::vector<results::Updates>> updates_;
  std::deque<Updates> observers_;
};

}  // namespace binnacle::python
