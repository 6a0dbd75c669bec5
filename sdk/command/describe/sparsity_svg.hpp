// SPDX-License-Identifier: Apache-2.0
// The state layout of every filter and the declared sparsity of its Φ, Qd and H, as a drawing.
#pragma once

#include <string>

#include "output.hpp"

namespace binnacle::command {

/// From what document::explain() gives. Every filled place is a <rect> of class "phi", "qd" or "h" and "dense",
/// "diagonal" or "identity", which says in data-row, data-column, data-rows, data-columns where it lies in P (an "h": its
/// columns, and the measurement and part that it is of).
std::string sparsity_svg(const Json& explained);

}  // namespace binnacle::command
