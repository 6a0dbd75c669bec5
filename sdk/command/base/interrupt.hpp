// SPDX-License-Identifier: Apache-2.0
// Signals that ask the command to stop in good order, and the watchdog for what does not.
#pragma once

#include <string>

namespace binnacle::command {

/// The first SIGINT, SIGTERM or SIGHUP from here on is noted, a second one ends the process at once. Unless stand_down()
/// comes within a second and a half of the first, a watchdog ends the process with status 1, names the plugin calls
/// that are under way and says what is `left` ("nothing was written").
void watch_signals(const std::string& left);

/// A second signal, at any time from here on, ends the process with status 1: the first asks for results.
void watch_second_signal();

/// The plugins' part is over, and what follows may take its time: results are being written.
void stand_down();

/// The signal that asked to stop; 0 while there was none. Any thread may ask.
int interrupted_by();

/// Ends the process by the signal, so that whoever started it sees that.
void die_of_signal();

}  // namespace binnacle::command
