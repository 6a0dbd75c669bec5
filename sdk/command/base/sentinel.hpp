// SPDX-License-Identifier: Apache-2.0
// Ends of the process that are not main's: exit() or std::terminate() in a plugin.
#pragma once

#include <string>

namespace binnacle::command {

/// From here on an exit() before leave() removes what is unfinished and ends with status 1 and an error that names the
/// plugin call under way; std::terminate() names it too. Called again after plugins are loaded, it comes before what
/// they want done at exit.
void watch_exit();

/// The command has done its work; returns `status`.
int leave(int status);

/// Removes what is unfinished, prints the error, and ends the process with status 1; any thread may.
[[noreturn]] void abandon(const std::string& message) noexcept;

}  // namespace binnacle::command
