// SPDX-License-Identifier: Apache-2.0
// What the simulator declares: its parameters and its channels.
#pragma once

#include <vector>

#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::vehicle_simulator {

ComponentSpec declare_component();

/// imu, gnss, truth, initial, in the order of VehicleSimulator::Channel.
std::vector<ChannelDeclaration> declare_channels(bool emits_rates, Time imu_interval);

}  // namespace binnacle::vehicle_simulator
