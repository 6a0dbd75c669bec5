// SPDX-License-Identifier: Apache-2.0
// The detection_score transform: for how many seconds a detector missed what was, and reported what was not.
#include "detection_score.hpp"

#include <algorithm>
#include <utility>

namespace binnacle::stationary_detector {

namespace {

FieldSpec standing(const char* text) { return field::level("standing", "1").about(text); }
FieldSpec duration(const char* name, const char* text) { return field::level(name, "s").about(text); }

}  // namespace

struct DetectionScore::Memory {
  Time t = no_time;                                        // counted until then; no_time: no truth yet
  double truth = 0;                                        // 1 or 0, what it was then
  double detected = -1;                                    // 1 or 0; −1: nothing yet
  double missed = 0, wrong = 0, standing = 0, moving = 0;  // s
};

ComponentSpec DetectionScore::spec() {
  ComponentSpec spec;
  spec.type = "detection_score";
  spec.summary =
      "Evaluates a detector: seconds of standing that it missed, and of motion that it reported as standing.";
  spec.parameters = {parameter::time("after").defaults("0").about("time before which nothing is evaluated")};
  spec.inputs = {
      input("detected", {standing("1 if the detector reports standing")}).about("channel 'state' of the detector"),
      input("truth", {standing("1 if the vehicle stands")}).about("truth, which determines the time resolution")};
  spec.example = R"json({"inputs": {"detected": "motion", "truth": "truth"}})json";
  return spec;
}

DetectionScore::DetectionScore(const Binding& binding)
    : after_(binding.parameters().time("after")),
      detected_(binding.input("detected")),
      truth_(binding.input("truth")),
      says_standing_(binding.field(detected_, "standing")),
      is_standing_(binding.field(truth_, "standing")),
      memory_(declaration_.keeps<Memory>()) {
  ChannelDeclaration channel;
  missed_ = channel.carries(duration("missed", "standing, but not detected"));
  false_ = channel.carries(duration("false", "moving, but detected as standing"));
  standing_ = channel.carries(duration("standing", "standing"));
  moving_ = channel.carries(duration("moving", "moving"));
  channel_ = declaration_.emits(std::move(channel));
}

void DetectionScore::on(const TransformInput& in, Emitter& emitter) const {
  Memory& memory = in.memory[memory_];
  const SampleView& sample = in.sample;
  if (memory.t != no_time && sample.t > memory.t && sample.t > after_) {
    const double dt = 1e-9 * (static_cast<double>(sample.t) - static_cast<double>(std::max(memory.t, after_)));
    const bool was_standing = memory.truth > 0.5, said_so = memory.detected > 0.5;
    (was_standing ? memory.standing : memory.moving) += dt;
    if (was_standing && !said_so) memory.missed += dt;
    if (!was_standing && said_so) memory.wrong += dt;
  }
  if (memory.t != no_time || in.from == truth_) memory.t = sample.t;
  if (in.from == detected_) {
    memory.detected = sample[says_standing_];
    return;
  }
  memory.truth = sample[is_standing_];
  SampleWriter& out = emitter.on(channel_);
  out.t = sample.t;
  out[missed_] = memory.missed;
  out[false_] = memory.wrong;
  out[standing_] = memory.standing;
  out[moving_] = memory.moving;
  emitter.emit(channel_);
}

}  // namespace binnacle::stationary_detector
