// SPDX-License-Identifier: Apache-2.0
// The lever arms of a config's filters, for `inspect` to compare with what turning shows.
#pragma once

#include <string>
#include <vector>

#include "binnacle/config.hpp"
#include "inspect/inspect.hpp"

namespace binnacle::command {

/// Of fixes: derived blocks with a fixed lever arm that a measurement of a channel is bound to. Rotations of the inertial samples are
/// followed to the source's axes, where they are roll, pitch, yaw; a lever arm behind any other transform is left out.
std::vector<inspect::StatedLeverArm> stated_lever_arms(const std::string& path, const LoadOptions& options);

}  // namespace binnacle::command
