// SPDX-License-Identifier: Apache-2.0
// Components bound for a test, without a composition: parameters are JSON as a config has it, ports are blocks of the test.
//
//     const AdditiveKind position(2, "m");
//     const auto range = binnacle::testing::bind<Range>({R"({"sigma": "10 cm"})", {{"position", &position}}});
//     const auto other = binnacle::testing::bind<MeasurementModel>(catalog, "range", {R"({"sigma": 0.1})", …});
//
// The kernel's own reader checks the parameters, converts their units and fills in defaults. Links with Binnacle::testing
// and Binnacle::kernel; whoever includes this sees no JSON library.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/catalog.hpp"
#include "binnacle/noise_estimator.hpp"
#include "binnacle/registry.hpp"
#include "binnacle/spec.hpp"
#include "binnacle/state_block.hpp"

namespace binnacle::testing {

/// JSON text, or the value of a JSON library, which has dump(); null stands for no parameters.
class JsonText {
 public:
  JsonText(const char* text) : text_(text) {}
  JsonText(std::string text) : text_(std::move(text)) {}
  template <class Json>
  requires requires(const Json& json) { std::string(json.dump()); }
  JsonText(const Json& json) : text_(json.dump()) {
    if (text_ == "null") text_ = "{}";
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// Everything that a component is bound to.
struct Setup {
  JsonText parameters = "{}";
  std::map<std::string, const StateBlock*> ports = {};  // a port that is not named stays open
  std::vector<std::string> without = {};                // optional fields that the channel lacks, inputs that stay open
  int samples_per_step = 1;
  std::vector<NamedUnit> covariance = {};                          // of the channel, or of the first input's
  std::vector<std::string> frozen = {};                            // ports none of whose components is estimated
  NoiseBinding noise = {};                                         // what an estimator is bound to
  std::map<std::string, const ChannelDeclaration*> channels = {};  // on whole inputs (ChannelPort::whole())
  std::string name = "under_test";                                 // the key under which it stands
  Findings* findings = nullptr;                                    // where figures and notes go
};

/// The parameters as the kernel reads them, complete and in SI. Throws ComponentError as bind() does.
ParameterValue read_parameters(const ComponentSpec& spec, const Setup& setup);

/// A Binding with all that it refers to.
class BoundTo {
 public:
  /// The spec must outlive it. Throws as bind() does.
  BoundTo(const ComponentSpec& spec, const Setup& setup);
  BoundTo(const BoundTo&) = delete;
  BoundTo& operator=(const BoundTo&) = delete;
  const Binding& binding() const { return binding_; }

 private:
  ParameterValue parameters_;
  Binding binding_;
};

/// A component of a class. What the kernel's reader refuses is a ComponentError like a refusal of the component's own: its
/// pointer is that of the parameter. Throws std::logic_error for what a test got wrong: a port that is not declared, or a
/// required one that is open. `more`: further arguments of the constructor, where a class has a second one for tests.
template <class Component, class... More>
std::unique_ptr<Component> bind(const Setup& setup = {}, More&&... more) {
  const ComponentSpec spec = Component::spec();
  const BoundTo bound(spec, setup);
  if constexpr (std::is_base_of_v<NoiseEstimator, Component>)
    return std::make_unique<Component>(bound.binding(), setup.noise);
  else
    return std::make_unique<Component>(bound.binding(), std::forward<More>(more)...);
}

/// The types that a function registers, as a plugin's does: `types_of([](Registry& registry) { registry.add<Range>(); })`.
Catalog types_of(std::function<void(Registry&)> add_types);

/// The type "range" or "plugin/range" of the role. Throws std::out_of_range where there is none.
const ComponentType& type_of(const Catalog& catalog, Role role, std::string_view name);

/// A component of a type that is registered, of the role's interface; it keeps its library loaded. Throws as above, and
/// std::out_of_range where there is no such type.
template <class Interface>
std::shared_ptr<Interface> bind(const Catalog& catalog, std::string_view type, const Setup& setup = {}) {
  const ComponentType& registered = type_of(catalog, role_of<Interface>(), type);
  const BoundTo bound(registered.spec, setup);
  return registered.template create<Interface>(bound.binding(), setup.noise);
}

}  // namespace binnacle::testing
