// SPDX-License-Identifier: Apache-2.0
// Registry: what a plugin is handed to say what it brings.
#pragma once

#include <memory>
#include <tuple>
#include <type_traits>
#include <utility>

#include "binnacle/derived_block.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/noise_estimator.hpp"
#include "binnacle/process_model.hpp"
#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle {

/// What a component is in a composition: the interface that it implements.
enum class Role {
  state_block,
  process_model,
  measurement_model,
  derived_block,
  noise_estimator,
  source,
  transform,
  sink
};

/// The interface behind each role.
using Interfaces =
    std::tuple<StateBlock, ProcessModel, MeasurementModel, DerivedBlock, NoiseEstimator, Source, Transform, Sink>;
template <Role role>
using Interface = std::tuple_element_t<static_cast<std::size_t>(role), Interfaces>;  ///< of one role

/// Of an interface, or of a component that is derived from it.
template <class Component, std::size_t i = 0>
constexpr Role role_of() {
  static_assert(i < std::tuple_size_v<Interfaces>, "not a Binnacle component");
  if constexpr (std::is_base_of_v<std::tuple_element_t<i, Interfaces>, Component>)
    return static_cast<Role>(i);
  else
    return role_of<Component, i + 1>();
}

template <class Base>
using Factory = std::unique_ptr<Base> (*)(const Binding&, const NoiseBinding&);  ///< makes a bound component
using AnyFactory = void (*)();                                                   ///< a Factory of the role's interface

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
    add<Component>(Component::spec());
  }
  /// A type whose spec is known at run time only.
  template <class Component>
  void add(ComponentSpec spec) {
    constexpr Role role = role_of<Component>();
    const Factory<Interface<role>> factory = &make<Interface<role>, Component>;
    add_component(role, std::move(spec), reinterpret_cast<AnyFactory>(factory));
  }

 protected:
  virtual void add_component(Role role, ComponentSpec spec, AnyFactory make) = 0;

 private:
  template <class Base, class Component>
  static std::unique_ptr<Base> make(const Binding& binding, [[maybe_unused]] const NoiseBinding& noise) {
    if constexpr (std::is_same_v<Base, NoiseEstimator>)
      return std::make_unique<Component>(binding, noise);
    else
      return std::make_unique<Component>(binding);
  }
};

}  // namespace binnacle
