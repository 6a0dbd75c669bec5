// SPDX-License-Identifier: Apache-2.0
// One check, run here and now; meant for a process of its own.
#pragma once

#include "check.hpp"

namespace binnacle::conform {

/// What the process reports to the driver: lines on a pipe, and in shared memory what it is calling. Without a pipe it reports
/// to people on stderr.
struct Wire {
  int pipe = -1;
  char* stage = nullptr;  // `stage_bytes`, shared
};
inline constexpr int stage_bytes = 64;

/// Runs the check. Returns an exit status: 1 if it fails.
int run_check(const Check& check, Trial& trial, const Wire& wire);

/// The Report that writes to the wire.
std::unique_ptr<Report> wire_report(const Wire& wire);

}  // namespace binnacle::conform
