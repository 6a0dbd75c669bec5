// SPDX-License-Identifier: Apache-2.0
// Signals that ask the command to stop in good order.
#pragma once

namespace binnacle::command {

/// The first SIGINT, SIGTERM or SIGHUP from here on is noted, a second one ends the process at once.
void watch_signals();

/// The signal that asked to stop; 0 while there was none. Any thread may ask.
int interrupted_by();

/// Ends the process by the signal, so that whoever started it sees that.
void die_of_signal();

}  // namespace binnacle::command
