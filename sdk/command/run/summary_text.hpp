// SPDX-License-Identifier: Apache-2.0
// The summary of a run as tables for people.
#pragma once

#include <string>

#include "binnacle/composition.hpp"
#include "output.hpp"

namespace binnacle::command {

std::string summary_text(const Json& summary, const Composition& composition);

}  // namespace binnacle::command
