// SPDX-License-Identifier: Apache-2.0
#include "cause_watch.hpp"

#include <cmath>
#include <cstdio>

#include "axis_words.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

Eigen::Vector3d vector_of(const SampleView& sample, const VectorFields& fields) {
  return {sample.fields[fields.index[0]], sample.fields[fields.index[1]], sample.fields[fields.index[2]]};
}

std::string clock_text(const FixFields& fix, const InertialFields& input, const InputFit::Shift& shift) {
  char text[96];
  std::snprintf(text, sizeof text, "best %.2f s %s than they are labelled (1-sigma %.2f s)", std::abs(shift.seconds),
                shift.seconds > 0 ? "earlier" : "later", shift.sigma);
  return "the samples of " + in_quotes(fix.channel_name) + " fit those of " + in_quotes(input.channel_name) + " " +
         text + ": one of the two clocks may be wrong";
}

}  // namespace

CauseWatch::CauseWatch(const MotionFields& fields) : fields_(fields) {
  for (const auto& fix : fields.fixes)
    fixes_.push_back({&fix, {}, fields.input ? std::make_unique<InputFit>() : nullptr});
}

void CauseWatch::sampled(int channel, const SampleView& sample) {
  if (fields_.input && channel == fields_.input->channel) {
    const Time t0 = sample.t0 != no_time ? sample.t0 : input_t_;
    const double dt = t0 == no_time ? 0 : seconds(sample.t - t0);
    Turns increment;
    increment << vector_of(sample, fields_.input->turn) * (fields_.input->turn.is_rate ? dt : 1),
        vector_of(sample, fields_.input->force) * (fields_.input->force.is_rate ? dt : 1);
    for (auto& fix : fixes_) fix.input_fit->add_input(t0, sample.t, increment);
    input_t_ = sample.t;
  }
  for (auto& fix : fixes_) {
    if (channel != fix.fields->channel) continue;
    const Eigen::Vector3d velocity = vector_of(sample, fix.fields->velocity);
    if (fix.fields->position) fix.field_fit.add(sample.t, vector_of(sample, *fix.fields->position), velocity);
    if (fix.input_fit) fix.input_fit->add_velocity(sample.t, velocity[0], velocity[1]);
  }
}

Diagnostics CauseWatch::causes() const {
  Diagnostics all;
  for (const auto& fix : fixes_) {
    const auto add = [&](const char* code, const std::string& text) {
      all.warning(code, fix.fields->origin, fix.fields->pointer, text);
    };
    const auto field_words = fix.field_fit.words(*fix.fields);
    for (const auto& text : field_words) add("B120", text);
    if (!fix.input_fit) continue;
    if (const auto shift = fix.input_fit->shift()) add("B119", clock_text(*fix.fields, *fields_.input, *shift));
    if (field_words.empty())  // else the course itself is not what it should be
      for (const auto& text : axis_words(fix.input_fit->axes(), *fields_.input, *fix.fields, fix.field_fit.is_right()))
        add("B120", text);
  }
  return all;
}

}  // namespace binnacle::score
