// SPDX-License-Identifier: Apache-2.0
// The smallest composition around one component, made of its example and of what that refers to.
#pragma once

#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "binnacle/composition.hpp"
#include "check.hpp"

namespace binnacle::conform {

using Json = nlohmann::ordered_json;

/// The names under which things stand in a miniature.
inline constexpr const char* component_name = "subject";
inline constexpr const char* filter_name = "filter";

/// The library under test and whatever else lies on the search path, as a catalog. Throws LoadError.
Catalog load_catalog(const Trial& trial);
/// The component under test. Throws std::out_of_range when it is not there.
const ComponentType& component(const Trial& trial, const Catalog& catalog);

/// Its example as JSON; throws Skip where there is none, std::runtime_error where it is no JSON object.
Json example_of(const ComponentSpec& spec);

/// The config: the component with `settings` (its example, or that with other parameters), and all it needs.
Json miniature(const Trial& trial, const ComponentType& type, const Catalog& catalog, const Json& settings);

/// The component's own pointer in that config.
std::string component_pointer(Role role);

/// Composed: throws what Composition::parse throws.
std::shared_ptr<const Composition> compose(const Trial& trial, const Json& config);
/// The example, composed.
std::shared_ptr<const Composition> compose_example(const Trial& trial);

}  // namespace binnacle::conform
