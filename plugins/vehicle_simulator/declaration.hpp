// SPDX-License-Identifier: Apache-2.0
// What the simulator declares: its parameters and its channels.
#pragma once

#include "binnacle/source.hpp"
#include "binnacle/spec.hpp"
#include "simulation/fields.hpp"

namespace binnacle::vehicle_simulator {

ComponentSpec declare_component();

/// Handles of all that is emitted.
struct Channels {
  struct Imu : simulation::ImuFields {
    OutputChannel channel;
  } imu;
  struct Gnss {
    OutputChannel channel;
    OutputFields<3> position, velocity, position_sd, velocity_sd;
  } gnss;
  struct Truth {
    OutputChannel channel;
    OutputFields<3> position, velocity, attitude, gyro_bias, accel_bias, gyro_scale, accel_scale, misalignment, rates;
    OutputField speed, standing;
  } truth;
  struct Initial {
    OutputChannel channel;
    OutputFields<3> position, velocity, attitude;
  } initial;
};

/// In the order of VehicleSimulator::Channel.
Channels declare_channels(SourceDeclaration& declaration, bool emits_rates, Time imu_interval);

}  // namespace binnacle::vehicle_simulator
