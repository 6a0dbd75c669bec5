// SPDX-License-Identifier: Apache-2.0
// The plugins that Python itself brings to every config: models written in Python, arrays as sources and sinks.
#pragma once

#include <memory>
#include <vector>

#include "binnacle/config.hpp"

namespace binnacle::python {

/// As they are now: what is registered later is not in them. Holds the GIL.
std::vector<std::shared_ptr<const LinkedPlugin>> linked_plugins();

}  // namespace binnacle::python
