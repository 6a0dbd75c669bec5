// SPDX-License-Identifier: Apache-2.0
// A composition as a graph in Graphviz' DOT language.
#pragma once

#include <string>

#include "output.hpp"

namespace binnacle::command {

/// `explained` is what document::explain() gives. Nodes are components, each named by its JSON pointer; edges are
/// channels from emitter to subscriber, and within a filter what is advanced, read, derived and measured.
std::string dot_text(const Json& explained);

}  // namespace binnacle::command
