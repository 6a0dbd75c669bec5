// SPDX-License-Identifier: Apache-2.0
#include "line_source.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace binnacle::stream {

namespace {

const ParameterValue* member(const ParameterValue& of, const std::string& key) {
  for (const auto& [name, value] : of.members)
    if (name == key && value.type != ParameterValue::Type::absent) return &value;
  return nullptr;
}

}  // namespace

void LineSource::add_parameters(ComponentSpec& spec) {
  for (ParameterSpec& each : line_input::Lines::parameters()) spec.parameters.push_back(std::move(each));
  spec.parameters.front().is_required = true;  // from
  spec.parameters.push_back(
      parameter::object("time", {parameter::text("key").about("name of the label in a line; default: \"t\""),
                                 parameter::number("unit", "*")
                                     .defaults("\"s\"")
                                     .about("unit of the label, for example \"s\", \"ms\", \"ns\""),
                                 parameter::time("offset").defaults("0").about("offset added to every label")})
          .about("time label of a line"));
  spec.parameters.push_back(
      parameter::time("interval")
          .above(0)
          .about("fixed length of the interval of a rate or increment; default: the time between labels"));
  spec.parameters.push_back(parameter::time("max_gap").above(0).defaults("\"1 s\"").about(
      "longest step between labels; after a longer step a rate or increment has no interval"));
  spec.parameters.push_back(parameter::time("max_ahead")
                                .above(0)
                                .defaults("\"10 s\"")
                                .about("longest step between labels without a pause as long; what is farther ahead is "
                                       "left out until labels go on from it"));
}

ParameterSpec LineSource::field_spec(const char* key, const char* about) {
  return parameter::object(
      "field", {parameter::text(key).about(about),
                parameter::number("unit", "*").required().about("unit of the numbers, for example \"deg/s\", \"g\""),
                parameter::choice("kind", {"level", "rate", "increment"})
                    .about("level: value at the label; rate: mean over the interval before it; increment: integral "
                           "over this interval")});
}

LineSource::LineSource(const Binding& binding) {
  const Parameters& parameters = binding.parameters();
  lines_ = std::make_unique<line_input::Lines>(parameters, parameters.time("max_ahead"));
  declaration_.live = true;
  if (parameters.has("interval")) interval_ = parameters.time("interval");
  max_gap_ = parameters.time("max_gap");
  if (!parameters.has("time")) return;
  for (const auto& [key, value] : parameters.members("time")) {
    if (value.type == ParameterValue::Type::absent) continue;
    if (key == "key") time_key_ = value.text;
    if (key == "offset") time_offset_ = value.integer;
    if (key != "unit") continue;
    time_unit_ = std::llround(value.number * 1e9);
    if (value.text != "s" || time_unit_ < 1)
      throw ComponentError("labels need a unit of time, like \"s\", \"ms\" or \"ns\"", "/time/unit");
  }
}

void LineSource::add_channel(const std::string& name, const std::vector<std::pair<std::string, ParameterValue>>& fields,
                             const char* key) {
  ChannelDeclaration channel;
  channel.name = name;
  ChannelPlan plan;
  plan.name = name;
  for (const auto& [field, value] : fields) {
    const ParameterValue *its_key = member(value, key), *unit = member(value, "unit"), *kind = member(value, "kind");
    plan.fields.push_back({its_key ? its_key->text : field, unit->number});
    FieldSpec spec;
    spec.name = field;
    spec.unit = unit->text;
    if (kind && kind->text != "level") {
      spec.kind = kind->text == "rate" ? FieldKind::rate : FieldKind::increment;
      plan.has_intervals = true;
    }
    channel.fields.push_back(std::move(spec));
  }
  if (channel.fields.empty()) throw ComponentError("no field is named", name.empty() ? "" : "/channels/" + name);
  if (plan.has_intervals) channel.max_interval = interval_.value_or(max_gap_);
  plan.output = declaration_.emits(std::move(channel));
  channels_.push_back(std::move(plan));
}

/// A long double has 64 bits of mantissa: seconds since 1970 are exact to the nanosecond.
Time LineSource::time_of(std::string_view text) const {
  const std::string copy(text);
  char* end = nullptr;
  const long double label = std::strtold(copy.c_str(), &end);
  if (end != copy.c_str() + copy.size() || copy.empty() || !std::isfinite(label))
    throw BadLine{"its time is not a number"};
  const long double t = label * static_cast<long double>(time_unit_);
  if (std::abs(t) > 4e18L) throw BadLine{"its time is out of range; is the unit of the time right?"};
  return static_cast<Time>(std::llroundl(t)) + time_offset_;
}

void LineSource::open(Reporter& reporter) {
  newest_->times.assign(channels_.size(), no_time);
  lines_->open(reporter);
}

SourceStatus LineSource::next(const MemoryView& /*memory*/, SourceOutput& out) const {
  constexpr int most_lines = 1000;  // that are no good, before the others are asked again
  for (int lines = 0; lines < most_lines; ++lines) {
    std::string_view line;
    switch (lines_->next(line)) {
      case line_input::Lines::Got::line:
        if (take(line, out)) return SourceStatus::sample;
        break;
      case line_input::Lines::Got::nothing: return SourceStatus::wait;
      case line_input::Lines::Got::end: return SourceStatus::end;
      case line_input::Lines::Got::anew: begin_anew(); break;
    }
  }
  return SourceStatus::wait;
}

bool LineSource::take(std::string_view line, SourceOutput& out) const {
  LineSample& sample = newest_->sample;
  sample.t = sample.t0 = no_time;
  try {
    if (!parse(line, sample)) return false;
    if (lines_->stamps_arrival()) {
      sample.t = line_input::monotonic_now();
      sample.t0 = no_time;
    }
    if (sample.t == no_time) throw BadLine{"it has no time '" + time_key_ + "'"};
    if (!lines_->accepts(sample.t)) return false;
    if (lines_->is_anew()) newest_->times.assign(channels_.size(), no_time);
    const auto is_finite = [](double value) { return std::isfinite(value); };
    if (std::ranges::none_of(sample.values, is_finite)) throw BadLine{"it has none of its channel's fields"};
    write(sample, out);
    if (!std::ranges::all_of(sample.values, is_finite))
      lines_->complain("a field is missing, or is not a number; it is taken as NaN");
    return true;
  } catch (const BadLine& bad) {
    lines_->complain(bad.why);
    return false;
  }
}

void LineSource::write(const LineSample& sample, SourceOutput& out) const {
  const ChannelPlan& channel = channels_[sample.channel];
  Time& newest = newest_->times[sample.channel];
  SampleWriter& to = out.on(channel.output);
  to.t = sample.t;
  to.t0 = sample.t0;
  if (channel.has_intervals && sample.t0 == no_time) {
    if (interval_)
      to.t0 = sample.t - *interval_;
    else if (newest != no_time && sample.t > newest && sample.t - newest <= max_gap_)
      to.t0 = newest;
  }
  if (newest == no_time || sample.t > newest) newest = sample.t;
  for (std::size_t i = 0; i < channel.fields.size(); ++i) to.fields[i] = sample.values[i] * channel.fields[i].scale;
}

}  // namespace binnacle::stream
