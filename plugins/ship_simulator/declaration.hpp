// SPDX-License-Identifier: Apache-2.0
// What the simulator declares: its parameters and its channels.
#pragma once

#include <vector>

#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::ship_simulator {

ComponentSpec declare_component();

/// In the order of ShipSimulator::Channel.
std::vector<ChannelDeclaration> declare_channels(Time imu_interval);

}  // namespace binnacle::ship_simulator
