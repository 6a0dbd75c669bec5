// SPDX-License-Identifier: Apache-2.0
// Parts of a composition: the bound models themselves, for programs that examine them one by one.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/composition.hpp"

namespace binnacle::parts {

/// What is plugged into a port.
struct Value {
  std::string name;                             // "" : the port is open
  std::shared_ptr<const StateBlock> block;      // null where it is derived
  std::shared_ptr<const DerivedBlock> derived;  // null where it is a block
  std::vector<double> initial;                  // stored value at the start, where the config gives it
};

/// A model as it is bound: ports, fields and driving rates in the order of its spec. Objects keep their plugin loaded.
template <class Model>
struct Part {
  const ComponentType* type = nullptr;  // lives as long as the composition
  std::shared_ptr<const Model> model;
  std::vector<Value> ports;
};

struct NoisePart {
  const ComponentType* type = nullptr;
  std::shared_ptr<const NoiseEstimator> estimator;
  int max_rows = 0;
};

/// Each throws std::out_of_range where there is no such part.
Value block(const Composition& composition, std::string_view filter, std::string_view name);
Part<ProcessModel> process(const Composition& composition, std::string_view filter, std::string_view name);
Part<DerivedBlock> derived(const Composition& composition, std::string_view filter, std::string_view name);
/// `part`: of a stack; "" where the measurement is none.
Part<MeasurementModel> measurement(const Composition& composition, std::string_view filter, std::string_view name,
                                   std::string_view part = {});
NoisePart noise(const Composition& composition, std::string_view filter, std::string_view measurement);
Part<Source> source(const Composition& composition, std::string_view name);
Part<Transform> transform(const Composition& composition, std::string_view name);

}  // namespace binnacle::parts
