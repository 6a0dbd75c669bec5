// SPDX-License-Identifier: Apache-2.0
// The source: one angle of a ship, by its shaping filter or as recorded, read by a gyro that drifts.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "binnacle/source.hpp"
#include "record.hpp"

namespace binnacle::ship_motion {

/// State: the motion's (none where it is recorded), accumulated drift, drift; exact from sample to sample.
class Simulator final : public Source {
 public:
  static ComponentSpec spec();
  explicit Simulator(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& output) const override;

  enum Channel { truth, gyro };  // the order of its channels

 private:
  static constexpr int max_states = 6;
  struct Memory;

  void initialise(std::uint64_t seed, const MemoryView& bytes) const override;
  using States = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, max_states, 1>;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, max_states, max_states>;

  void declare_channels();
  void discretize(double interval);
  bool is_recorded() const { return place_.has_value(); }
  bool is_over(const Memory& memory) const;

  std::optional<RecordPlace> place_;
  Record record_;
  Time interval_ = 0, duration_ = 0;  // of a motion that is not recorded
  int order_ = 0;                     // of the motion
  Square F_, density_, root_P_;       // continuous form, root of the first covariance
  Square Phi_, root_Q_;               // per interval
  double noise_;                      // rad
  OutputChannel truth_channel_, gyro_channel_;
  OutputField angle_, rate_, error_, drift_;  // of truth; the rate only of a motion that is not recorded
  OutputField reading_;                       // of gyro
  binnacle::Memory<Memory> memory_;
};

}  // namespace binnacle::ship_motion
