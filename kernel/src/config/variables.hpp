// SPDX-License-Identifier: Apache-2.0
// "${name}" in the texts of a config, from its "vars" and from --var.
#pragma once

#include <map>
#include <string>

#include "binnacle/diagnostic.hpp"
#include "config/node.hpp"

namespace binnacle::config {

/// Fills in every text below root, "vars" itself included. A text that is one "${name}" and nothing else
/// takes the variable's value with its type. A text that begins with a variable takes that variable's folder.
void fill_in_variables(Node& root, const std::map<std::string, std::string>& given, const Folder& current_folder,
                       Diagnostics& diagnostics);

}  // namespace binnacle::config
