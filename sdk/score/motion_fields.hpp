// SPDX-License-Identifier: Apache-2.0
// Which fields of a filter's channels say how the vehicle moves: what the likely cause of a doubt is looked for in.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/section.hpp"

namespace binnacle::score {

/// Three fields of a channel that are one vector.
struct VectorFields {
  std::array<int, 3> index{};         // among the per-epoch fields of a sample
  std::array<std::string, 3> name{};  // in the channel
  bool is_rate = false;               // else increments, or levels
};

/// A measurement whose samples carry the velocity over ground north, east, down, and perhaps the geodetic position.
struct FixFields {
  int channel = -1;
  std::string channel_name, measurement, pointer;
  Origin origin;
  VectorFields velocity;
  std::optional<VectorFields> position;
};

/// The driving input, where it is an inertial one.
struct InertialFields {
  int channel = -1;
  std::string channel_name;
  VectorFields turn, force;  // angular rate and specific force
  std::string rolls = {};    // a measurement by which the vehicle moves along the first axis alone; empty: none
};

struct MotionFields {
  int filter = 0;
  std::vector<FixFields> fixes;
  std::optional<InertialFields> input;
};

/// Those of every filter that has any, found by units and by the names that models declare: a measurement's fields are
/// what they are called if the filter has a block with outputs of these names. Subscribes to their channels.
std::vector<MotionFields> read_motion_fields(CompositionDraft& draft);

}  // namespace binnacle::score
