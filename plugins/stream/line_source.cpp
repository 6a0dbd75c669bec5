// SPDX-License-Identifier: Apache-2.0
#include "line_source.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>

namespace binnacle::stream {

namespace {

using Clock = std::chrono::steady_clock;

Time monotonic_now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch()).count();
}

std::string seconds_text(Clock::duration time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", std::chrono::duration<double>(time).count());
  return text;
}

const ParameterValue* member(const ParameterValue& of, const std::string& key) {
  for (const auto& [name, value] : of.members)
    if (name == key && value.type != ParameterValue::Type::absent) return &value;
  return nullptr;
}

/// A line that is longer is no line.
constexpr std::size_t longest_line = 1 << 20;

}  // namespace

struct LineSource::Fault {
  std::int64_t count = 0, told_next = 1;
};

struct LineSource::Intake {
  Reporter* reporter = nullptr;
  std::string buffer;
  std::size_t begin = 0;  // of what was not taken yet
  int line = 0;
  bool is_cut = false;  // the rest of a line that was given up
  std::map<std::string, Fault> faults;
  std::vector<Time> newest;  // by channel
  LineSample sample;
  Clock::time_point last = Clock::now();
  bool is_silent = false;
  std::int64_t losses_told_next = 1;
};

void LineSource::add_parameters(ComponentSpec& spec) {
  spec.parameters.push_back(parameter::path("from").required().about(
      "stdin:, file:PATH (followed as it grows), tcp://HOST:PORT, tcp://:PORT (a server), udp://:PORT, "
      "serial:///dev/ttyUSB0?baud=115200"));
  spec.parameters.push_back(
      parameter::object("time",
                        {parameter::text("key").about("its name in a line; default: \"t\""),
                         parameter::number("unit", "*").defaults("\"s\"").about("of the label: \"s\", \"ms\", \"ns\""),
                         parameter::time("offset").defaults("0").about("added to every label")})
          .about("the label of a line"));
  spec.parameters.push_back(parameter::choice("stamp", {"data", "arrival"})
                                .defaults("\"data\"")
                                .about("data: a sample has the time that it carries; arrival: that of the machine's "
                                       "monotonic clock when it came"));
  spec.parameters.push_back(
      parameter::time("interval")
          .above(0)
          .about("fixed length of the interval that a rate or increment belongs to; default: from label to label"));
  spec.parameters.push_back(parameter::time("max_gap").above(0).defaults("\"1 s\"").about(
      "after a longer step between labels a rate or increment has no interval"));
  spec.parameters.push_back(parameter::time("silence").above(0).defaults("\"5 s\"").about(
      "when nothing came for so long, a warning says so"));
  spec.parameters.push_back(parameter::choice("on_error", {"skip", "stop"})
                                .defaults("\"skip\"")
                                .about("skip: a line that is no good is counted and reported; stop: it ends the run"));
}

ParameterSpec LineSource::field_spec(const char* key, const char* about) {
  return parameter::object("field",
                           {parameter::text(key).about(about),
                            parameter::number("unit", "*").required().about("of the numbers: \"deg/s\", \"g\""),
                            parameter::choice("kind", {"level", "rate", "increment"})
                                .about("level: a value at the label; rate, increment: over the interval before it")});
}

LineSource::LineSource(const Binding& binding) {
  const Parameters& parameters = binding.parameters();
  endpoint_ = std::make_unique<Endpoint>(parse_address(parameters.text("from")));
  declaration_.live = true;
  stamps_arrival_ = parameters.text("stamp") == "arrival";
  stops_ = parameters.text("on_error") == "stop";
  if (parameters.has("interval")) interval_ = parameters.time("interval");
  max_gap_ = parameters.time("max_gap");
  silence_ = parameters.time("silence");
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
    throw BadLine{"its time is no number"};
  const long double t = label * static_cast<long double>(time_unit_);
  if (std::abs(t) > 4e18L) throw BadLine{"its time is out of range; is the unit of the time right?"};
  return static_cast<Time>(std::llroundl(t)) + time_offset_;
}

void LineSource::open(Reporter& reporter) {
  intake_ = std::make_shared<Intake>();
  intake_->reporter = &reporter;
  intake_->newest.assign(channels_.size(), no_time);
  endpoint_->open();
}

SourceStatus LineSource::next(const MemoryView& /*memory*/, SourceOutput& out) const {
  constexpr int most_lines = 1000;  // that are no good, before the others are asked again
  Intake& intake = *intake_;
  for (int lines = 0; lines < most_lines;) {
    const auto end = intake.buffer.find('\n', intake.begin);
    if (end != std::string::npos) {
      const std::string_view line = std::string_view(intake.buffer).substr(intake.begin, end - intake.begin);
      intake.begin = end + 1;
      ++lines;
      if (take_line(intake, line, out)) return SourceStatus::sample;
      continue;
    }
    intake.buffer.erase(0, intake.begin);
    intake.begin = 0;
    if (intake.buffer.size() > longest_line) {
      intake.buffer.clear();
      intake.is_cut = true;
      complain(intake, "it has no end within a megabyte");
    }
    const auto got = endpoint_->read(intake.buffer);
    watch_silence(intake, got == Endpoint::Got::bytes);
    watch_losses(intake);
    if (got == Endpoint::Got::nothing) return SourceStatus::wait;
    if (got == Endpoint::Got::end) {
      if (intake.buffer.empty()) return SourceStatus::end;
      intake.buffer += '\n';  // the last line may lack its end
    }
    if (got == Endpoint::Got::lost || got == Endpoint::Got::found) {
      if (!intake.buffer.empty()) complain(intake, "the connection was lost in the middle of it");
      intake.buffer.clear();
      begin_anew();
      intake.reporter->warn("B067", endpoint_->address().text, intake.line,
                            got == Endpoint::Got::lost
                                ? "nobody is there, or the connection was lost; it is tried again each second"
                                : "the connection is there again");
    }
  }
  return SourceStatus::wait;
}

bool LineSource::take_line(Intake& intake, std::string_view line, SourceOutput& out) const {
  ++intake.line;
  if (std::exchange(intake.is_cut, false)) return false;
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (line.find_first_not_of(" \t") == line.npos) return false;
  LineSample& sample = intake.sample;
  sample.t = sample.t0 = no_time;
  try {
    if (!parse(line, sample)) return false;
    if (stamps_arrival_) {
      sample.t = monotonic_now();
      sample.t0 = no_time;
    }
    if (sample.t == no_time) throw BadLine{"it has no time '" + time_key_ + "'"};
    bool is_any = false;
    for (const double value : sample.values) is_any = is_any || std::isfinite(value);
    if (!is_any) throw BadLine{"it has none of its channel's fields"};
    write(intake, sample, out);
    for (const double value : sample.values)
      if (!std::isfinite(value)) {
        complain(intake, "a field is missing, or is no number; it is taken as NaN");
        break;
      }
    return true;
  } catch (const BadLine& bad) {
    complain(intake, bad.why);
    return false;
  }
}

void LineSource::write(Intake& intake, const LineSample& sample, SourceOutput& out) const {
  const ChannelPlan& channel = channels_[sample.channel];
  Time& newest = intake.newest[sample.channel];
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

/// The first of a kind at once, then the tenth, the hundredth, …
void LineSource::complain(Intake& intake, const std::string& why) const {
  if (stops_)
    throw ComponentError::in_data("the line is no good: " + why, endpoint_->address().text, intake.line, "B062");
  Fault& fault = intake.faults[why];
  if (++fault.count < fault.told_next) return;
  fault.told_next *= 10;
  const std::string text =
      fault.count == 1 ? "a line is no good: " : std::to_string(fault.count) + " lines so far are no good: ";
  intake.reporter->warn("B062", endpoint_->address().text, intake.line, text + why);
}

void LineSource::watch_losses(Intake& intake) const {
  if (endpoint_->lost() < intake.losses_told_next) return;
  while (intake.losses_told_next <= endpoint_->lost()) intake.losses_told_next *= 10;
  intake.reporter->warn("B065", endpoint_->address().text, intake.line,
                        std::to_string(endpoint_->lost()) +
                            " datagrams so far came faster than the filter works, and were lost");
}

void LineSource::watch_silence(Intake& intake, bool came) const {
  const auto now = Clock::now();
  if (came) {
    if (std::exchange(intake.is_silent, false))
      intake.reporter->warn("B065", endpoint_->address().text, intake.line,
                            "it came back after " + seconds_text(now - intake.last));
    intake.last = now;
  } else if (!intake.is_silent && now - intake.last > std::chrono::nanoseconds(silence_)) {
    intake.is_silent = true;
    intake.reporter->warn("B065", endpoint_->address().text, intake.line,
                          "it has been silent for " + seconds_text(now - intake.last));
  }
}

}  // namespace binnacle::stream
