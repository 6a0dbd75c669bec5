// SPDX-License-Identifier: Apache-2.0
// Metrics against a plan, for the composer, which has no Composition yet.
#pragma once

#include <string_view>

#include "binnacle/metric.hpp"
#include "compose/composition_plan.hpp"

namespace binnacle {

Parsed<Metric> read_metric(const CompositionPlan& plan, std::string_view text);

}  // namespace binnacle
