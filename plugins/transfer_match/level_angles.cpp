// SPDX-License-Identifier: Apache-2.0
// A body's attitude angles, told as those of the axes in which it is mounted.
#include "level_angles.hpp"

#include <numbers>

#include "binnacle/view.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::transfer_match {

namespace {

std::vector<FieldSpec> angles(const std::string& of) {
  std::vector<FieldSpec> fields;
  for (const char* name : {"roll", "pitch", "yaw"})
    fields.push_back({name, "rad", FieldKind::level, false, false, of});
  return fields;
}

}  // namespace

ComponentSpec LevelAngles::spec() {
  ComponentSpec spec;
  spec.type = "level_angles";
  spec.summary = "Roll, pitch and yaw of a body, told as those of the axes in which it is mounted.";
  spec.parameters = {parameter::vector("mounting", "rad", 3)
                         .required()
                         .at_least(-2.0 * std::numbers::pi)
                         .at_most(2.0 * std::numbers::pi)
                         .about("roll, pitch, yaw of the body in those axes")};
  spec.inputs = {{"input", angles("of the body"), false, "the body's attitude"}};
  spec.example = R"json({"input": "truth", "mounting": [0, "90 deg", 0]})json";
  return spec;
}

LevelAngles::LevelAngles(const Binding& binding)
    : q_br_(strapdown::quaternion_conjugate(
          strapdown::quaternion_from_euler(binding.parameters().vector("mounting")))) {
  ChannelDeclaration channel;
  channel.fields = angles("of the axes in which the body is mounted");
  channels_.push_back(std::move(channel));
}

void LevelAngles::on(int /*input*/, const SampleView& sample, std::byte* /*memory*/, Emitter& emitter) const {
  SampleSlot& slot = emitter.slot(0);
  slot.t = sample.t;
  vector_at<3>(slot.fields) = strapdown::euler_from_quaternion(
      strapdown::quaternion_product(strapdown::quaternion_from_euler(vector_at<3>(sample.fields)), q_br_));
  emitter.emit(0);
}

}  // namespace binnacle::transfer_match
