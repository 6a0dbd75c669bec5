// SPDX-License-Identifier: Apache-2.0
// The filter engine: one run of one composed filter. Everything that outlives a call lies in the arena; the workspace
// is scratch, so that a snapshot is a copy of the arena's bytes.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "binnacle/plugin_call.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/step_log.hpp"
#include "filter/exclusion.hpp"
#include "filter/plan.hpp"

namespace binnacle {

class Engine {
 public:
  /// plan, channels and arena must outlive the engine. Allocates its workspace here and nothing afterwards.
  Engine(const FilterPlan& plan, const std::vector<ChannelPlan>& channels, std::byte* arena);

  /// Initialises the arena for a new run.
  void reset();
  void attach(StepObserver* observer);

  /// Samples as their channel lays them out. What is not listened to must not be handed in.
  void push_input(const SampleView& sample);
  void push_measurement(int measurement, const SampleView& sample);
  void push_auxiliary(int auxiliary, const SampleView& sample);
  void push_initial(int initial, const SampleView& sample);
  /// The end of the run: what still waits for input gets its outcome.
  void finish();
  /// Starts the filter at t when all its initial values are there; called once all samples of the instant are in.
  void try_start(Time t);

  const FilterHead& status() const { return *plan_.head.in(arena_); }
  bool started() const { return status().started != 0; }
  bool broken() const { return status().broken != 0; }
  /// Whether a channel that initial values come from ever had a sample.
  bool has_heard(const LatestPlan& initial) const { return latest(initial).available; }
  /// "velocity.north is not finite at 12.3 s"; empty while the filter is well.
  const char* diagnosis() const { return status().diagnosis; }
  /// Which plugin's call is under way, for other threads.
  CallSite& call_site() { return call_site_; }
  /// Stops the filter because the plugin call under way threw.
  void stop_for_exception(const char* what);
  /// Places without a count are free.
  std::span<const LeftOut> left_out(int measurement) const {
    const auto& place = plan_.measurements[static_cast<std::size_t>(measurement)].left_out;
    return {place.in(arena_), place.count};
  }
  const Ledger& ledger(int measurement) const {
    return *plan_.measurements[static_cast<std::size_t>(measurement)].ledger.in(arena_);
  }
  const double* state() const { return plan_.state.in(arena_); }
  MatrixView covariance() const { return {plan_.covariance.in(arena_), plan_.n, plan_.n, padded(plan_.n)}; }
  const FilterPlan& plan() const { return plan_; }
  /// The estimates as a sample of the filter's own channel: outputs of all blocks, P in their error dof.
  void write_estimates(SampleSlot& slot);

 private:
  FilterHead& head() { return *plan_.head.in(arena_); }
  double* x() { return plan_.state.in(arena_); }
  double* P() { return plan_.covariance.in(arena_); }
  double* at(std::size_t offset) { return workspace_.data() + offset; }

  void start_blocks(Time t);
  void add_pending(Time t0, Time t1, Time whole_t0, double whole_dt, const double* fields);
  void drain_queue(Time until);
  void advance_to(Time t);
  void step_pending(int whole);
  void step_fragment(Time t1);
  void step(Time t1, int samples);
  void remember_driving_rates(const InputSample& sample);
  bool propagate_models(Time t0, Time t1, int samples);
  void run_van_loan(const VanLoanGroup& group, double dt);
  void gather(const std::vector<GatherPlan>& plans, const std::vector<double*>& table);
  void hold_frozen();
  void check_health();
  void fail(const std::string& diagnosis);
  void calling(const std::string& component, const char* call) {
    component_ = &component;
    call_ = call;
    call_site_.enter(nullptr, component, call);
  }

  Result evaluate_derived(const std::vector<int>& values, bool with_jacobians);
  Driving driving(const std::vector<int>& fields, double* storage);
  void enqueue(int measurement, const SampleView& sample);
  void process(int measurement, const SampleView& sample);
  void process_or_reject(int measurement, const SampleView& sample);
  Result linearize(const MeasurementPlan& plan, const SampleView& sample, int& rows);
  void assemble(const PartPlan& part, int first_row, int rows);
  void inject(double* delta);
  MatrixView dense_H(const MeasurementPlan& plan, int rows);
  void estimate_noise(const MeasurementPlan& plan, Time t, int rows);
  void recover(const MeasurementPlan& plan);
  void count_left_out(const MeasurementPlan& plan);
  void conclude(int measurement, Time t, Outcome outcome, const char* reason, int rows, double nis, bool linearized,
                const double* delta);
  bool is_withheld(const MeasurementPlan& plan, Time t) const;
  SampleView latest(const LatestPlan& plan) const;

  const FilterPlan& plan_;
  const std::vector<ChannelPlan>& channels_;
  std::byte* arena_;
  StepObserver* observer_ = nullptr;
  const std::string* component_ = nullptr;  // whose code runs: named if it throws
  const char* call_ = "";
  CallSite call_site_;
  int in_process_ = -1;  // measurement that has no outcome yet

  // Scratch. Sized in the constructor, never resized.
  std::vector<double> workspace_;
  std::vector<const double*> values_;  // per value: where it lies
  std::vector<double*> phi_, noise_;   // tables of blocks
  std::vector<double> x_plus_;
  std::vector<double> predict_scratch_;
  std::vector<const double*> port_values_;  // per port of the model being called
  std::vector<double*> port_outputs_;
  std::vector<InputSample> samples_;
  std::vector<InputSample> model_samples_;
  std::vector<double> sample_fields_;  // of samples_, raw
  std::vector<double> model_fields_;   // of model_samples_, converted
  std::vector<double> gathered_;       // fields of a measurement
  std::vector<double> gathered_rows_;
  std::vector<SampleView> auxiliary_views_;
  std::vector<double> auxiliary_fields_;
  std::vector<double> driving_rate_fields_;
  std::vector<MatrixView> jacobians_;
  std::vector<double> H_, R_, r_, G_, HPHt_, S_, L_, K_, U_, y_, delta_, post_fit_, R_nominal_;
  std::vector<std::int64_t> row_keys_;
  std::vector<int> row_groups_;
  std::vector<std::int64_t> left_out_keys_;  // of the sample in process
  std::vector<int> left_out_groups_;
  int left_out_ = 0;
  OutlierTest outlier_test_;
  std::vector<std::byte> memory_backup_;
  std::vector<double> x_before_, P_before_, Phi_dense_, H_dense_;
  std::vector<double> block_delta_, block_reset_, reset_scratch_;
  UpdateWork work_;
};

/// Reads a component's fields from a channel's sample, converted. Returns the index into `map.names` of a required
/// per-epoch field that is not finite, or −1.
int read_fields(const FieldMap& map, const SampleView& sample, double dt, double* epoch);
void read_row_fields(const FieldMap& map, const ChannelPlan& channel, const SampleView& sample, double* rows);

}  // namespace binnacle
