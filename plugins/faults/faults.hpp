// SPDX-License-Identifier: Apache-2.0
// The faults transform: any channel, spoilt in windows or at random.
#pragma once

#include <vector>

#include "binnacle/source.hpp"
#include "fault.hpp"

namespace binnacle::faults {

/// One channel in, the same channel out: fields, rows and covariance as they come, but for what the faults do to them, one
/// after the other.
class Faults final : public Transform {
 public:
  static ComponentSpec spec();
  explicit Faults(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  struct Memory {
    Time first = no_time;  // label of the first sample
  };
  void initialise(std::uint64_t seed, const MemoryView& memory) const override;

  std::vector<Fault> faults_;
  OutputChannel out_;
  binnacle::Memory<Memory> memory_;
  MemoryArray<FaultMemory> of_fault_;
  MemoryArray<double> held_;
};

}  // namespace binnacle::faults
