// SPDX-License-Identifier: Apache-2.0
// The aiding_simulator transform: from where a vehicle is to what its sensors read.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "sensor.hpp"

namespace binnacle::aiding_simulator {

/// Each sensor that is given reads at a sample of the input, no sooner than `every` after its last reading, on the channel
/// NAME.SENSOR. NAME.truth has all slow errors, at each sample of the input, before the readings.
class AidingSimulator final : public Transform {
 public:
  static ComponentSpec spec();
  explicit AidingSimulator(const Binding& binding);

  void on(const TransformInput& in, Emitter& emitter) const override;

 private:
  struct SensorMemory;
  struct ErrorMemory;
  struct Part {
    std::string name;
    std::unique_ptr<const Sensor> sensor;
    Time every;
    std::vector<SlowError> errors;
    std::size_t first_error;  // of all sensors'
    OutputChannel channel;
  };

  void initialise(std::uint64_t seed, const MemoryView& bytes) const override;
  void advance(const MemoryView& bytes, double dt) const;
  void emit_errors(Time t, const MemoryView& bytes, Emitter& emitter) const;

  bool is_perfect_;
  std::vector<Part> parts_;
  Fields<3> position_, velocity_, attitude_, rates_;
  OutputChannel truth_;
  std::vector<OutputField> error_fields_;
  Memory<Time> last_;
  MemoryArray<SensorMemory> of_sensor_;
  MemoryArray<ErrorMemory> of_error_;
  MemoryArray<double> values_;  // of all errors at this instant
};

}  // namespace binnacle::aiding_simulator
