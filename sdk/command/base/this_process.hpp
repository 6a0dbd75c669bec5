// SPDX-License-Identifier: Apache-2.0
// This process as others name it, also on another machine that sees the same files.
#pragma once

#include <string>

namespace binnacle::command {

/// "process 1234 on HOST".
std::string name_of_this_process();
/// Letters, digits and "-", which no other process has: host, process, and a random number.
std::string unique_suffix();

}  // namespace binnacle::command
