// SPDX-License-Identifier: Apache-2.0
// The detection_score transform: for how many seconds a detector missed what was, and told what was not.
#include "detection_score.hpp"

#include <algorithm>
#include <new>
#include <type_traits>

namespace binnacle::stationary_detector {

namespace {

enum Input { detected_input, truth_input };

FieldSpec standing(const char* text) { return {"standing", "1", FieldKind::level, false, false, text}; }
FieldSpec duration(const char* name, const char* text) { return {name, "s", FieldKind::level, false, false, text}; }

}  // namespace

struct DetectionScore::Memory {
  Time t;                                  // counted until then; no_time: no truth yet
  double truth;                            // 1 or 0, what it was then
  double detected;                         // 1 or 0; −1: nothing yet
  double missed, wrong, standing, moving;  // s
};

ComponentSpec DetectionScore::spec() {
  ComponentSpec spec;
  spec.type = "detection_score";
  spec.summary =
      "For how many seconds a detector missed that the vehicle stood, and told that it stood when it did not.";
  spec.parameters = {parameter::time("after").defaults("0").about("what was before this time does not count")};
  spec.inputs = {{"detected", {standing("1 where the detector says so")}, false, "a detector's channel state"},
                 {"truth", {standing("1 where it is so")}, false, "what was; sets the resolution in time"}};
  spec.example = R"json({"inputs": {"detected": "motion", "truth": "truth"}})json";
  return spec;
}

DetectionScore::DetectionScore(const Binding& binding) : after_(binding.parameters().time("after")) {
  ChannelDeclaration channel;
  channel.fields = {duration("missed", "it stood, and the detector did not say so"),
                    duration("false", "it moved, and the detector said that it stood"),
                    duration("standing", "it stood"), duration("moving", "it moved")};
  channels_.push_back(std::move(channel));
}

std::size_t DetectionScore::memory_bytes() const noexcept { return sizeof(Memory); }

void DetectionScore::start(std::uint64_t /*seed*/, std::byte* memory) const {
  static_assert(std::is_trivially_copyable_v<Memory> && alignof(Memory) <= 8);
  new (memory) Memory{no_time, 0, -1, 0, 0, 0, 0};
}

void DetectionScore::on(int input, const SampleView& sample, std::byte* bytes, Emitter& emitter) const {
  Memory& memory = *std::launder(reinterpret_cast<Memory*>(bytes));
  if (memory.t != no_time && sample.t > memory.t && sample.t > after_) {
    const double dt = 1e-9 * (static_cast<double>(sample.t) - static_cast<double>(std::max(memory.t, after_)));
    const bool was_standing = memory.truth > 0.5, said_so = memory.detected > 0.5;
    (was_standing ? memory.standing : memory.moving) += dt;
    if (was_standing && !said_so) memory.missed += dt;
    if (!was_standing && said_so) memory.wrong += dt;
  }
  if (memory.t != no_time || input == truth_input) memory.t = sample.t;
  if (input == detected_input) {
    memory.detected = sample.fields[0];
    return;
  }
  memory.truth = sample.fields[0];
  SampleSlot& slot = emitter.slot(0);
  slot.t = sample.t;
  slot.fields[0] = memory.missed;
  slot.fields[1] = memory.wrong;
  slot.fields[2] = memory.standing;
  slot.fields[3] = memory.moving;
  emitter.emit(0);
}

}  // namespace binnacle::stationary_detector
