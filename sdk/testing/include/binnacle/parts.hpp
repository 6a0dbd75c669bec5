// SPDX-License-Identifier: Apache-2.0
// Parts of a composition: its bound models with what is plugged into them, looked up by name, for tests that call them one
// by one. Needs Binnacle::kernel.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/catalog.hpp"
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

/// A noise estimator as it is bound, for at most max_rows rows.
struct NoisePart {
  const ComponentType* type = nullptr;
  std::shared_ptr<const NoiseEstimator> estimator;
  int max_rows = 0;
};

namespace detail {

template <class Infos>
const auto& named(const Infos& infos, std::string_view name) {
  for (const auto& info : infos)
    if (info.name == name) return info;
  throw std::out_of_range("the composition has no part '" + std::string(name) + "'");
}

inline Value value_of(const BlockInfo& info) { return {info.name, info.block, nullptr, info.initial}; }

template <class Model>
Part<Model> part_of(const BoundInfo<Model>& info, const FilterInfo* filter = nullptr) {
  Part<Model> part{info.type, info.object, {}};
  for (const int value : info.ports) {
    const auto index = static_cast<std::size_t>(value);
    if (value < 0) {
      part.ports.push_back({});
    } else if (index < filter->blocks.size()) {
      part.ports.push_back(value_of(filter->blocks[index]));
    } else {
      const auto& derived = filter->derived[index - filter->blocks.size()];
      part.ports.push_back({derived.name, nullptr, derived.object, {}});
    }
  }
  return part;
}

}  // namespace detail

// Each throws std::out_of_range where there is no such part.

inline Value block(const Composition& composition, std::string_view filter, std::string_view name) {
  return detail::value_of(detail::named(detail::named(composition.filters(), filter).blocks, name));
}
inline Part<ProcessModel> process(const Composition& composition, std::string_view filter, std::string_view name) {
  const FilterInfo& info = detail::named(composition.filters(), filter);
  return detail::part_of<ProcessModel>(detail::named(info.processes, name), &info);
}
inline Part<DerivedBlock> derived(const Composition& composition, std::string_view filter, std::string_view name) {
  const FilterInfo& info = detail::named(composition.filters(), filter);
  return detail::part_of(detail::named(info.derived, name), &info);
}
/// `part`: of a stack; "" where the measurement is none.
inline Part<MeasurementModel> measurement(const Composition& composition, std::string_view filter,
                                          std::string_view name, std::string_view part = {}) {
  const FilterInfo& info = detail::named(composition.filters(), filter);
  const auto& parts = detail::named(info.measurements, name).parts;
  return detail::part_of(part.empty() ? parts.front() : detail::named(parts, part), &info);
}
inline NoisePart noise(const Composition& composition, std::string_view filter, std::string_view measurement) {
  const auto& info = detail::named(detail::named(composition.filters(), filter).measurements, measurement);
  if (!info.noise.object) throw std::out_of_range("'" + info.name + "' has no noise estimator");
  return {info.noise.type, info.noise.object, info.max_rows};
}
inline Part<Source> source(const Composition& composition, std::string_view name) {
  const auto sources = composition.sources();
  return detail::part_of<Source>(detail::named(sources, name));
}
inline Part<Transform> transform(const Composition& composition, std::string_view name) {
  const auto transforms = composition.transforms();
  return detail::part_of<Transform>(detail::named(transforms, name));
}

}  // namespace binnacle::parts
