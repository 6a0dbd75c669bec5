// SPDX-License-Identifier: Apache-2.0
// What the simulator declares: its parameters and its channels.
#pragma once

#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"
#include "simulation/fields.hpp"

namespace binnacle::ship_simulator {

ComponentSpec declare_component();

/// Handles of all that is emitted.
struct Channels {
  struct Imu : simulation::ImuFields {
    OutputChannel channel;
  } imu;
  struct Mins {
    OutputChannel channel;
    OutputFields<3> velocity, position, attitude;
  } mins;
  struct State {
    OutputChannel channel;
    OutputFields<3> position, velocity, attitude, level_attitude;
  } truth, initial;
  struct Mounting {
    OutputChannel channel;
    OutputFields<3> misalignment;
  } mounting;
};

/// In the order of ShipSimulator::Channel.
Channels declare_channels(SourceDeclaration& declaration, Time imu_interval);

}  // namespace binnacle::ship_simulator
