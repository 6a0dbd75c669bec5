// SPDX-License-Identifier: Apache-2.0
// What tuning found, for people.
#pragma once

#include <string>

#include "output.hpp"
#include "tune/tune.hpp"

namespace binnacle::command {

/// Parameters at the start and at the end, and how both are judged.
std::string tune_text(const Json& result, const tune::Plan& plan);

}  // namespace binnacle::command
