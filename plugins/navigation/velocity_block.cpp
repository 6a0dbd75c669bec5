// SPDX-License-Identifier: Apache-2.0
// A velocity over ground in north-east-down axes.
#include "velocity_block.hpp"

#include "binnacle/view.hpp"

namespace binnacle::navigation {

ComponentSpec VelocityBlock::spec() {
  ComponentSpec spec;
  spec.type = "velocity";
  spec.former_names = {"phi_error/velocity"};
  spec.summary = "Velocity over ground, north, east, down.";
  spec.source = "paper 003, equation (2)";
  spec.kind = "velocity.ned";
  spec.example = R"json({"init": {"vn": 0, "ve": 0, "vd": 0}, "sigma": "0.1 m/s"})json";
  return spec;
}

VelocityBlock::VelocityBlock(const Binding& /*binding*/) {
  declaration_.kind = "velocity.ned";
  declaration_.stored_size = 3;
  declaration_.error = {{"north", "m/s"}, {"east", "m/s"}, {"down", "m/s"}};
  declaration_.outputs = {{"vn", "m/s", "", false, false, "velocity over ground, north"},
                          {"ve", "m/s", "", false, false, "velocity over ground, east"},
                          {"vd", "m/s", "", false, false, "velocity over ground, down"}};
  declaration_.norms = {{"horizontal", {0, 1}}};
}

}  // namespace binnacle::navigation
