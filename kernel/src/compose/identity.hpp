// SPDX-License-Identifier: Apache-2.0
// By what a source or transform is the same as one of another composition.
#pragma once

#include <string>

#include "compose/composer.hpp"

namespace binnacle::internal::compose {

/// All that decides what it emits but seed and run, in bytes for comparison. Empty: live, or it subscribes to
/// what is not made of recorded sources alone.
std::string identity_of(const CompositionPlan& plan, const Component& component, const SourcePlan& source);
std::string identity_of(const CompositionPlan& plan, const Component& component, const TransformPlan& transform);
inline std::string identity_of(const CompositionPlan&, const Component&, const SinkPlan&) { return {}; }

}  // namespace binnacle::internal::compose
