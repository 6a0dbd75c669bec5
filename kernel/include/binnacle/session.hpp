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
#include "binnacle/noise_estimator.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/step_log.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

namespace runtime {
class Runtime;
}

/// Counts of what became of a measurement's samples since the start.
struct MeasurementCounts {
  std::int64_t offered = 0;
  std::int64_t by_outcome[outcome_count] = {};  // indexed by Outcome
  std::int64_t before_start = 0;                // came before the filter had its initial values
  std::int64_t recoveries = 0;
  std::int64_t rows_left_out = 0;  // of accepted samples, by a gate by row or key
  double nis_mean = 0;             // of accepted samples; NaN when there is none
  std::int64_t nis_count = 0;      // of them
  double dof_mean = 0;             // rows per accepted sample
  std::string last_reason;         // of the newest sample that was not accepted
};

/// One running composition: all of its filters and transforms, none of its sources.
///
/// Look up names once, before the loop; inside it push() and the readers neither allocate nor search. Not thread safe;
/// any number of Filters may share one Composition across threads.
///
///     auto composition = binnacle::Composition::load("ins.json");
///     binnacle::Session filter(composition);
///     const int imu = filter.channel("imu");
///     const auto position = filter.block("ins/position");
///     filter.push(imu, t0, t1, {fields, 6});
///     filter.read(position, outputs);
class Session {
 public:
  /// A state block of a filter, found once by name.
  struct Block {
    int filter = 0;
    int block = 0;
  };

  /// As after reset(seed, run).
  explicit Session(std::shared_ptr<const Composition> composition, std::uint64_t seed = 0, int run = 0);
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// "imu". Throws ConfigError (B020) with the nearest name.
  int channel(std::string_view name) const;
  /// "ins/position"; the block alone where there is one filter. Throws ConfigError (B015) with the nearest name.
  Block block(std::string_view name) const;
  /// "ins". Throws ConfigError (B027).
  int filter(std::string_view name) const;

  /// A sample on a channel: per-epoch fields in the channel's order, SI. t0 < t for rates and increments, no_time else.
  /// Samples of one channel come in order of time; a measurement may be ahead of the driving input, then it waits.
  void push(int channel, Time t0, Time t, std::span<const double> fields);
  /// The same with rows or a covariance.
  void push(int channel, const SampleView& sample);
  /// Several samples of one instant, worked on together: inputs first, then measurements in config order. (One push()
  /// is an instant of its own.)
  void add(int channel, const SampleView& sample);
  void commit(Time t);

  bool started(int filter) const;
  /// False once the filter is broken: diagnosis() says why, and it takes no more samples.
  bool healthy(int filter) const;
  std::string diagnosis(int filter) const;
  /// Of the filter's estimates; no_time before it has started.
  Time time(int filter) const;

  /// When it started; no_time before.
  Time start_time(int filter) const;

  /// The block's readable outputs (roll, pitch, yaw), in the order of its declaration [SI].
  void read(Block block, std::span<double> outputs) const;
  /// Standard deviations of those outputs, to first order [SI]. `outputs.size()` numbers.
  void read_sigma(Block block, std::span<double> sigmas) const;
  /// The block's part of P: one row and column per estimated or considered error component.
  MatrixView covariance(Block block) const;
  /// The whole P of a filter, rows as FilterInfo tells.
  MatrixView covariance(int filter) const;
  /// The filter's stored state, laid out as FilterInfo tells.
  std::span<const double> state(int filter) const;

  MeasurementCounts counts(int filter, int measurement) const;
  void attach(int filter, StepObserver* observer);

  /// Everything that this run is, as bytes; restored into a Session of the same composition it goes on bit for bit.
  std::size_t snapshot_size() const;
  void snapshot(std::span<std::byte> into) const;
  /// Throws ConfigError (B082) when the bytes are of another composition or version, and then changes nothing.
  void restore(std::span<const std::byte> from);
  /// Back to before the first sample.
  void reset(std::uint64_t seed = 0, int run = 0);

  const Composition& composition() const { return *composition_; }
  runtime::Runtime& runtime() { return *runtime_; }  // the kernel's own

 private:
  std::shared_ptr<const Composition> composition_;
  std::unique_ptr<runtime::Runtime> runtime_;
  mutable std::vector<double> scratch_;
};

}  // namespace binnacle
