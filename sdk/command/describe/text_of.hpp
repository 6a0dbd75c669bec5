// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "output.hpp"

namespace binnacle::command {

/// A text of what document::explain() gives.
inline std::string text_of(const Json& object, const char* key) { return object.at(key).get<std::string>(); }

}  // namespace binnacle::command
