// SPDX-License-Identifier: Apache-2.0
// Registry: what a plugin is handed to say what it brings.
#pragma once

#include <memory>
#include <type_traits>

#include "binnacle/derived_block.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/noise_estimator.hpp"
#include "binnacle/process_model.hpp"
#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle {

template <class Base>
using Factory = std::unique_ptr<Base> (*)(const Binding&);
using NoiseFactory = std::unique_ptr<NoiseEstimator> (*)(const Binding&, const NoiseBinding&);

/// A component is a class with `static ComponentSpec spec()` and a constructor from `const Binding&` (noise estimators:
/// also `const NoiseBinding&`), derived from one of the interfaces:
///
///     BINNACLE_PLUGIN("my_plugin", "1.0.0", registry) {
///       registry.add<MyBlock>();
///       registry.add<MyProcess>();
///     }
class Registry {
 public:
  virtual ~Registry() = default;

  template <class Component>
  void add() {
    if constexpr (std::is_base_of_v<StateBlock, Component>) {
      add_state_block(Component::spec(), &make<StateBlock, Component>);
    } else if constexpr (std::is_base_of_v<ProcessModel, Component>) {
      add_process_model(Component::spec(), &make<ProcessModel, Component>);
    } else if constexpr (std::is_base_of_v<MeasurementModel, Component>) {
      add_measurement_model(Component::spec(), &make<MeasurementModel, Component>);
    } else if constexpr (std::is_base_of_v<DerivedBlock, Component>) {
      add_derived_block(Component::spec(), &make<DerivedBlock, Component>);
    } else if constexpr (std::is_base_of_v<NoiseEstimator, Component>) {
      add_noise_estimator(Component::spec(), &make_noise<Component>);
    } else if constexpr (std::is_base_of_v<Source, Component>) {
      add_source(Component::spec(), &make<Source, Component>);
    } else if constexpr (std::is_base_of_v<Transform, Component>) {
      add_transform(Component::spec(), &make<Transform, Component>);
    } else {
      static_assert(std::is_base_of_v<Sink, Component>, "not a Binnacle component");
      add_sink(Component::spec(), &make<Sink, Component>);
    }
  }

 protected:
  virtual void add_state_block(ComponentSpec spec, Factory<StateBlock> make) = 0;
  virtual void add_process_model(ComponentSpec spec, Factory<ProcessModel> make) = 0;
  virtual void add_measurement_model(ComponentSpec spec, Factory<MeasurementModel> make) = 0;
  virtual void add_derived_block(ComponentSpec spec, Factory<DerivedBlock> make) = 0;
  virtual void add_noise_estimator(ComponentSpec spec, NoiseFactory make) = 0;
  virtual void add_source(ComponentSpec spec, Factory<Source> make) = 0;
  virtual void add_transform(ComponentSpec spec, Factory<Transform> make) = 0;
  virtual void add_sink(ComponentSpec spec, Factory<Sink> make) = 0;

 private:
  template <class Base, class Component>
  static std::unique_ptr<Base> make(const Binding& binding) {
    return std::make_unique<Component>(binding);
  }
  template <class Component>
  static std::unique_ptr<NoiseEstimator> make_noise(const Binding& binding, const NoiseBinding& noise) {
    return std::make_unique<Component>(binding, noise);
  }
};

}  // namespace binnacle
