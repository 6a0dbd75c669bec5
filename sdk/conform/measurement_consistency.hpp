// SPDX-License-Identifier: Apache-2.0
// numbers.measurement.consistency: the normalized innovations of a filter that believes the model.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "fixture.hpp"

namespace binnacle::conform {

/// The measurement of the example, and what it remembers at the start.
struct MeasurementSubject {
  explicit MeasurementSubject(Trial& trial) : composition(compose_example(trial)), measurement(trial, *composition) {
    memory = measurement.caller.fresh_memory();
  }
  std::shared_ptr<const Composition> composition;
  MeasurementFixture measurement;
  std::vector<std::byte> memory;
};

void measurement_consistency(Trial& trial);

}  // namespace binnacle::conform
