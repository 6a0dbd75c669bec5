// SPDX-License-Identifier: Apache-2.0
// Session: a composition running inside your program. Push samples, read estimates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/step_log.hpp"
#include "binnacle/trust.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

namespace internal::filter {
class Engine;
}
namespace internal::runtime {
class History;
class Runtime;
}  // namespace internal::runtime

/// What became of a measurement's samples since the start.
struct MeasurementCounts : SampleCounts {
  std::vector<RowFigures> rows = {};
  double nis_mean = 0;      // of accepted samples; NaN when there is none
  double dof_mean = 0;      // rows per accepted sample
  std::string last_reason;  // of the newest sample that was not accepted
};

/// Counts of a filter's driving input since the start.
struct FilterCounts {
  std::int64_t steps = 0;
  std::int64_t input_gaps = 0;  // bridged
  double seconds = 0;           // of computing time spent in it, estimated from one instant in seven
  Time longest_lag = 0;         // of live estimates behind what had arrived: with a budget of `history`
};

/// Counts of what was pushed on a channel since the Session was made or reset.
struct ChannelCounts {
  std::int64_t pushed = 0;
  /// Older than one before on the channel. A measurement behind its filter is `late`, a driving input behind is not used.
  std::int64_t behind = 0;
};

/// What a name stands for, in Sessions of one Composition; `index` counts as Composition lists them. Made by Session's
/// look-ups, or by hand: FilterId{0} is the first filter.
struct ChannelId {
  int index = -1;
};
/// A filter, as ChannelId.
struct FilterId {
  int index = -1;
};
/// A state block of a filter, as ChannelId; `index` counts as FilterInfo::blocks.
struct BlockId {
  FilterId filter;
  int index = -1;
};
/// A measurement of a filter, as ChannelId; `index` counts as FilterInfo::measurements.
struct MeasurementId {
  FilterId filter;
  int index = -1;
};

/// One running composition: all of its filters and transforms, none of its sources.
///
/// Look up names once, before the loop; inside it push() and the readers neither allocate nor search. Not thread safe;
/// any number of Sessions may share one Composition across threads. What is wrong in a call is refused before anything
/// changes: std::out_of_range for an id that the composition does not have, std::invalid_argument for a span of another
/// size or an interval that does not end after it began. What a plugin throws breaks its filter, or is a FilterError that
/// names plugin, component, call and time.
///
///     auto composition = binnacle::Composition::load("ins.json");
///     binnacle::Session session(composition);
///     const auto imu = session.channel("imu");
///     const auto position = session.block("ins/position");
///     session.push(imu, t0, t1, {fields, 6});
///     session.read(position, outputs);
class Session {
 public:
  /// As after reset(seed, run). estimates: what all that is asked for is of, where a filter has `history`.
  explicit Session(std::shared_ptr<const Composition> composition, std::uint64_t seed = 0, int run = 0,
                   Estimates estimates = Estimates::live);
  /// The kernel's own, for run(): is_ordered: nothing can be late.
  Session(std::shared_ptr<const Composition> composition, std::uint64_t seed, int run, Estimates estimates,
          bool is_ordered);
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// "imu". Throws ConfigError (B020) with the nearest name.
  ChannelId channel(std::string_view name) const;
  /// "ins/position"; the block alone where there is one filter. Throws ConfigError (B015) with the nearest name.
  BlockId block(std::string_view name) const;
  /// "ins". Throws ConfigError (B027) with the nearest name.
  FilterId filter(std::string_view name) const;
  /// "ins/fix"; the measurement alone where there is one filter. Throws ConfigError (B027) with the nearest name.
  MeasurementId measurement(std::string_view name) const;

  /// A sample on a channel: per-epoch fields in the channel's order, SI. t0 < t for rates and increments, no_time else.
  /// Samples of one channel come in order of time: one that is older than another before it is taken, and counted
  /// (ChannelCounts::behind). A measurement may be ahead of the driving input, then it waits.
  void push(ChannelId channel, Time t0, Time t, std::span<const double> fields);
  /// The same with rows or a covariance.
  void push(ChannelId channel, const SampleView& sample);
  /// Several samples of one instant t, at most one per channel, worked on together: inputs first, then measurements in
  /// config order. (One push() is an instant of its own.) commit() takes the time that the samples have; where none was
  /// added, filters with history go on with what their budget left.
  void add(ChannelId channel, const SampleView& sample);
  void commit(Time t);

  bool started(FilterId filter) const;
  /// False once the filter is broken: diagnosis() says why, and it takes no more samples.
  bool healthy(FilterId filter) const;
  std::string diagnosis(FilterId filter) const;
  /// What its models noted so far: a warning (B083) for each, with plugin, component, call, time of the first, and count.
  Diagnostics notes(FilterId filter) const;
  /// Of the filter's estimates; no_time before it has started.
  Time time(FilterId filter) const;

  /// When it started; no_time before.
  Time start_time(FilterId filter) const;

  /// The block's readable outputs (roll, pitch, yaw), as declared [SI]; the span has as many. NaN before the filter has started.
  void read(BlockId block, std::span<double> outputs) const;
  /// Standard deviations of those outputs, to first order [SI]; the span has as many. NaN before the start.
  void read_sigma(BlockId block, std::span<double> sigmas) const;
  /// The block's part of P: one row and column per estimated or considered error component.
  ConstMatrixView covariance(BlockId block) const;
  /// The whole P of a filter, rows as FilterInfo gives them.
  ConstMatrixView covariance(FilterId filter) const;
  /// The filter's stored state, laid out as FilterInfo gives it.
  std::span<const double> state(FilterId filter) const;

  /// Whether its estimates hold so far, by the limits of its "trust"; `ok` before started(). Allocates nothing.
  Verdict verdict(FilterId filter) const;
  /// Why it is not `ok`, and notes: writes as many as there is room for, returns how many there are. Allocates nothing.
  std::size_t reasons(FilterId filter, std::span<TrustReason> into) const;
  /// The same reasons in the same order, without notes unless `least` is ok, as warnings (B100 and following) with their places.
  Diagnostics doubts(FilterId filter, Verdict least = Verdict::doubtful) const;

  MeasurementCounts counts(MeasurementId measurement) const;
  FilterCounts counts(FilterId filter) const;
  ChannelCounts counts(ChannelId channel) const;
  /// In the place of the observer that was attached before; null: nobody.
  void attach(FilterId filter, StepObserver* observer);
  /// Beside it: of a section's part of a run, which sees every sample once and no rerun().
  void attach_section(FilterId filter, StepObserver* observer);
  /// Emits estimates of a filter, made from its steps, on a channel of its section (NAME.smoothed): an instant of its own. t
  /// may lie behind; x: stored state, P: covariance, both as FilterInfo lays them out.
  void push_estimates(ChannelId channel, FilterId filter, Time t, const double* x, ConstMatrixView P);

  /// Everything that this run is, as bytes; restored into a Session of the same composition it goes on bit for bit. With
  /// latency or history its size changes with what is under way; the other Session shows the same Estimates.
  std::size_t snapshot_size() const;
  void snapshot(std::span<std::byte> into) const;
  /// Throws ConfigError (B082) when the bytes are damaged, or of another composition or version, and then changes nothing.
  void restore(std::span<const std::byte> from);
  /// Back to before the first sample.
  void reset(std::uint64_t seed = 0, int run = 0);

  Estimates shown() const { return shown_; }
  const Composition& composition() const { return *composition_; }
  internal::runtime::Runtime& runtime() const { return *runtime_; }  // the kernel's own

 private:
  /// What came on a channel, to see what is out of order.
  struct Intake {
    Time newest = no_time;
    ChannelCounts counts;
  };
  // Checked.
  internal::filter::Engine& engine(FilterId filter) const;
  /// Null: it has none, or nothing can be late.
  const internal::runtime::History* history_of(FilterId filter) const;
  /// Its live estimates, by more than the history.
  bool was_lagging(FilterId filter) const;
  const BlockInfo& info(BlockId block) const;
  const Intake& intake(ChannelId channel) const;
  void take(ChannelId channel, const SampleView& sample);
  template <class Call>
  void read(BlockId block, std::span<double> outputs, const char* call_name, Call&& call) const;

  std::shared_ptr<const Composition> composition_;
  std::unique_ptr<internal::runtime::Runtime> runtime_;
  Estimates shown_;
  std::vector<Intake> intake_;  // by channel
  Time instant_ = no_time;      // of what was added and is not committed
  mutable std::vector<double> scratch_;
};

/// Standard deviations of a block's outputs: sqrt(diag(J P Jᵀ)) with J = ∂outputs/∂δ, as the block's output_jacobian() says,
/// else by central differences on its manifold. x: the block's stored state; P: the filter's covariance, or any whose rows from block.first_row on are the
/// block's active components.
void output_sigmas(const BlockInfo& block, const double* x, ConstMatrixView P, double* scratch, double* sigmas);
/// Doubles of scratch that it needs.
std::size_t output_sigma_scratch(const BlockInfo& block);

}  // namespace binnacle
