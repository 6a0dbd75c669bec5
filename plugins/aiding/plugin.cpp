// SPDX-License-Identifier: Apache-2.0
// What the plugin `aiding` brings.
#include "binnacle/plugin.hpp"

#include "attitude_fix.hpp"
#include "bearing.hpp"
#include "body_velocity.hpp"
#include "course.hpp"
#include "heading.hpp"
#include "height.hpp"
#include "magnetometer.hpp"
#include "range.hpp"
#include "range_difference.hpp"

BINNACLE_TYPES("attitude_fix bearing body_velocity course heading height magnetometer range range_difference");

BINNACLE_PLUGIN("aiding", "1.1.0", registry) {
  using namespace binnacle::aiding;
  registry.add<AttitudeFix>();
  registry.add<Bearing>();
  registry.add<BodyVelocity>();
  registry.add<Course>();
  registry.add<Heading>();
  registry.add<Height>();
  registry.add<Magnetometer>();
  registry.add<Range>();
  registry.add<RangeDifference>();
}
