// SPDX-License-Identifier: Apache-2.0
// Collector: what a run records, kept in memory as results::RunWriter keeps it in run.nc.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "observers.hpp"
#include "results.hpp"
#include "results/run_writer.hpp"
#include "run_recorder.hpp"
#include "score/run.hpp"
#include "step_log.hpp"
#include "step_observers.hpp"

namespace binnacle::python {

/// Asked now and then whether the run goes on; throws where it does not.
using Check = std::function<void()>;

/// What is kept of a run, by filter, and who looks on.
struct Kept {
  bool records = true;  // reading estimates costs more than a filter step
  bool updates = true;
  std::map<std::string, Wants> logs = {};  // by filter: its step log, with what is wanted of it
};

class Collector : public score::RunObserver {
 public:
  /// check: asked at progress. recorder: where it is all written as well; null: nowhere.
  Collector(const Composition& composition, const Kept& kept, Check check, command::RunRecorder* recorder);
  /// Calls it from now on. Throws TypeError. The GIL is held.
  void observe(std::size_t filter, const py::object& observer);

  bool wants_records() const override { return kept_.records || recorder_; }
  void begin(int filter, const std::string& name, const std::vector<score::RecordColumn>& columns) override;
  void record(int filter, Time t, std::span<const double> values) override;
  StepObserver* step_observer(int filter) override;
  void scored(int filter, const score::ErrorSeries& errors) override;
  void after_instant() override { failure_.raise(); }
  void finished() override { failure_.raise(); }
  bool progress(Time t) override;

  /// All that was kept, by filter. The GIL is held.
  py::list taken();

 private:
  class UpdateLog : public StepObserver {
   public:
    explicit UpdateLog(std::vector<results::Updates>& into) : into_(into) {}
    void offered(const UpdateRecord& record) override;

   private:
    std::vector<results::Updates>& into_;
  };
  struct Filter {
    explicit Filter(const FilterInfo& info);
    const FilterInfo& info;
    Records records;
    std::vector<results::Error> errors;
    std::vector<results::Updates> updates;  // by measurement
    UpdateLog update_log{updates};
    std::unique_ptr<StepLog> log;
    std::unique_ptr<PythonObserver> observer;
    command::StepObservers all;
  };

  Kept kept_;
  Check check_;
  command::RunRecorder* recorder_;
  Failure failure_;
  std::deque<Filter> filters_;
};

}  // namespace binnacle::python
