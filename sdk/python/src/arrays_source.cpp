// SPDX-License-Identifier: Apache-2.0
#include "arrays_source.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "array_intervals.hpp"

namespace binnacle::python {

namespace {

ParameterSpec column_spec() {
  return parameter::object(
      "field", {parameter::number("unit", "*")
                    .required()
                    .about("unit of the numbers in the array, for example \"deg/s\", \"g\", \"m\", \"1\""),
                parameter::choice("kind", {"level", "rate", "increment"})
                    .defaults("\"level\"")
                    .about("level: value at the sample's time; rate: mean over the interval that ends there; "
                           "increment: integral over this interval"),
                parameter::list("missing", parameter::text("value"))
                    .about("numbers that mean \"no data\": \"nan\", \"-9999\"; without it a NaN is an error")});
}

const ParameterValue* member(const ParameterValue& object, std::string_view name) {
  for (const auto& [key, value] : object.members)
    if (key == name && value.type != ParameterValue::Type::absent) return &value;
  return nullptr;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "'" : ", '") + name + "'";
  return text;
}

void read_missing(const ParameterValue& list, const std::string& pointer, bool& may_be_nan,
                  std::vector<double>& numbers) {
  for (const auto& element : list.elements) {
    double number = 0;
    const char* const end = element.text.data() + element.text.size();
    const auto [rest, error] = std::from_chars(element.text.data(), end, number);
    if (error != std::errc() || rest != end)
      throw ComponentError("'" + element.text + "' is not a number, and an array holds nothing else",
                           pointer + "/missing");
    may_be_nan |= std::isnan(number);
    if (!std::isnan(number)) numbers.push_back(number);
  }
}

FieldKind kind_of(const std::string& text) {
  return text == "rate" ? FieldKind::rate : text == "increment" ? FieldKind::increment : FieldKind::level;
}

}  // namespace

ComponentSpec ArraysSource::spec() {
  ComponentSpec spec;
  spec.type = "arrays";
  spec.summary = "samples from arrays of a Python program: load(…, data={\"imu\": (t, {\"wx\": …})})";
  spec.parameters = {
      parameter::text("content").about("digest that identifies the arrays; data= of load() and parse() sets it"),
      parameter::map("columns", column_spec()).required().about("fields of the channel"),
      parameter::time("interval")
          .above(0)
          .about("fixed length of the interval of a rate or increment; default: the time between samples"),
      parameter::time("max_gap").above(0).about(
          "longest step between times; a longer step is reported, and the sample after it has no interval; default: "
          "ten times the median step for rates and increments, otherwise no limit"),
      parameter::object("rows", {parameter::text("key").required().about("field that identifies the rows of a sample"),
                                 parameter::integer("max_rows").at_least(1).at_most(4096).defaults("64")})
          .about("lines with the same time are the rows of one sample; every field is then per row")};
  return spec;
}

ArraysSource::ArraysSource(const Binding& binding) : file_("data['" + binding.name() + "']") {
  const Parameters& parameters = binding.parameters();
  const std::string how = "load() and parse() take them: data={'" + binding.name() + "': (t, {'field': array})}";
  if (!parameters.has("content")) throw ComponentError("no arrays were given for this source; " + how);
  data_ = find_arrays(parameters.text("content"));
  if (!data_) throw ComponentError("this program has no arrays of this content; " + how, "/content");
  ChannelDeclaration channel;
  read_columns(parameters, channel);
  if (parameters.has("rows")) read_rows(parameters, channel);
  read_intervals(parameters, channel);
  check_times();
  check_values();
  channel_ = declaration_.emits(std::move(channel));
  next_ = declaration_.keeps<std::uint64_t>();
}

void ArraysSource::read_columns(const Parameters& parameters, ChannelDeclaration& channel) {
  for (const auto& [name, value] : parameters.members("columns")) {
    const std::string pointer = join_pointer("/columns", name);
    const auto found = std::ranges::find(data_->names, name);
    if (found == data_->names.end())
      throw ComponentError(file_ + " has no field '" + name + "'; it has " + list_of(data_->names), pointer);
    Column column;
    column.name = name;
    column.index = static_cast<std::size_t>(found - data_->names.begin());
    const ParameterValue& unit = *member(value, "unit");
    column.scale = unit.number;
    if (const auto* kind = member(value, "kind")) column.kind = kind_of(kind->text);
    if (const auto* missing = member(value, "missing"))
      read_missing(*missing, pointer, column.may_be_nan, column.missing);
    has_intervals_ |= column.kind != FieldKind::level;
    channel.fields.push_back({name, unit.text, column.kind});
    columns_.push_back(std::move(column));
  }
  if (columns_.empty()) throw ComponentError("no field is named", "/columns");
}

void ArraysSource::read_rows(const Parameters& parameters, ChannelDeclaration& channel) {
  const Parameters rows = parameters.object("rows");
  const auto found = std::ranges::find(columns_, rows.text("key"), &Column::name);
  if (found == columns_.end()) throw ComponentError("no field '" + rows.text("key") + "' among columns", "/rows/key");
  if (has_intervals_)
    throw ComponentError("with rows every field is a level: the rows of a sample are of one instant", "/rows");
  key_ = static_cast<std::size_t>(found - columns_.begin());
  for (FieldSpec& field : channel.fields) field.is_per_row = true;
  channel.max_rows = static_cast<int>(rows.integer("max_rows"));
  for (std::size_t line = 0; line < data_->times.size(); ++line) {
    if (!times_.empty() && data_->times[line] == times_.back()) continue;
    times_.push_back(data_->times[line]);
    begins_.push_back(line);
  }
  begins_.push_back(data_->times.size());
  for (std::size_t i = 0; i + 1 < begins_.size(); ++i)
    if (begins_[i + 1] - begins_[i] > static_cast<std::size_t>(channel.max_rows))
      refuse("B062", "more than " + std::to_string(channel.max_rows) + " rows at " + seconds_text(times_[i]) +
                         ": raise rows/max_rows if that many are right");
}

void ArraysSource::read_intervals(const Parameters& parameters, ChannelDeclaration& channel) {
  if (parameters.has("max_gap")) max_gap_ = parameters.time("max_gap");
  if (parameters.has("interval")) interval_ = parameters.time("interval");
  const bool is_given = interval_ || !data_->starts.empty();
  if (is_given && !has_intervals_)
    throw ComponentError("an interval needs a field of kind \"rate\" or \"increment\"",
                         interval_ ? "/interval" : "/columns");
  if (interval_ && !data_->starts.empty()) throw ComponentError("its arrays have begins of intervals too", "/interval");
  if (!has_intervals_) return;
  channel.max_interval = interval_.value_or(max_gap_.value_or(nanoseconds_per_second));
  Time longest = 0;
  for (std::size_t i = 0; i < data_->starts.size(); ++i)
    if (data_->starts[i] != no_time) longest = std::max(longest, data_->times[i] - data_->starts[i]);
  if (longest > 0) channel.max_interval = longest;
}

void ArraysSource::refuse(const std::string& code, const std::string& message) const {
  throw ComponentError::in_data(message, file_, 0, code);
}

void ArraysSource::check_times() const {
  const auto& times = data_->times;
  if (times.empty()) refuse("B066", "there are no samples");
  for (std::size_t i = 1; i < times.size(); ++i)
    if (key_ ? times[i] < times[i - 1] : times[i] <= times[i - 1])
      refuse("B063", std::string(key_ ? "time goes back: " : "time does not increase: ") + seconds_text(times[i]) +
                         " at index " + std::to_string(i) + " after " + seconds_text(times[i - 1]));
  for (std::size_t i = 0; i < data_->starts.size(); ++i)
    if (data_->starts[i] != no_time && data_->starts[i] >= times[i])
      refuse("B063", "t0 is not before t at index " + std::to_string(i) + ": " + seconds_text(data_->starts[i]) +
                         " and " + seconds_text(times[i]));
}

void ArraysSource::check_values() const {
  const std::size_t width = data_->names.size();
  for (const Column& column : columns_)
    for (std::size_t line = 0; line < data_->times.size(); ++line) {
      const double number = data_->values[line * width + column.index];
      if (std::isfinite(number) || (std::isnan(number) && column.may_be_nan)) continue;
      refuse("B064", "field '" + column.name + "' is " +
                         (std::isnan(number) ? "nan"
                          : number > 0       ? "inf"
                                             : "-inf") +
                         " at index " + std::to_string(line) + " (t = " + seconds_text(data_->times[line]) + ")" +
                         (std::isnan(number) ? ": if that means \"no data\", say so with missing=[\"nan\"]" : ""));
    }
  for (std::size_t i = 0; i + 1 < begins_.size(); ++i) check_keys(begins_[i], begins_[i + 1]);
}

void ArraysSource::check_keys(std::size_t begin, std::size_t end) const {
  const Column& key = columns_[*key_];
  for (std::size_t line = begin; line < end; ++line) {
    const double number = value(line, key);
    if (std::isnan(number))
      refuse("B062", "field '" + key.name + "', the key of the rows, is missing at index " + std::to_string(line));
    for (std::size_t other = begin; other < line; ++other)
      if (value(other, key) == number)
        refuse("B062", "field '" + key.name + "' has the same number twice at " + seconds_text(data_->times[line]) +
                           ", at the indices " + std::to_string(other) + " and " + std::to_string(line));
  }
}

void ArraysSource::open(Reporter& reporter) {
  if (!has_intervals_ && !max_gap_) return;
  const auto& times = key_ ? times_ : data_->times;
  if (!data_->starts.empty()) {
    starts_ = data_->starts;
    return;
  }
  const Gaps gaps = find_gaps(times, max_gap_, has_intervals_);
  if (has_intervals_) starts_ = starts_of(times, interval_, gaps);
  if (!gaps.ends.empty()) reporter.warn("B065", file_, 0, text_of(gaps, times));
}

/// In SI; NaN where it stands for "no data".
double ArraysSource::value(std::size_t line, const Column& column) const {
  const double number = data_->values[line * data_->names.size() + column.index];
  for (const double missing : column.missing)
    if (number == missing) return std::numeric_limits<double>::quiet_NaN();
  return number * column.scale;
}

SourceStatus ArraysSource::next(const MemoryView& memory, SourceOutput& output) const {
  const auto& times = key_ ? times_ : data_->times;
  std::uint64_t& next = memory[next_];
  if (next >= times.size()) return SourceStatus::end;
  const auto i = static_cast<std::size_t>(next++);
  SampleWriter& out = output.on(channel_);
  out.t = times[i];
  out.t0 = starts_.empty() ? no_time : starts_[i];
  const std::size_t begin = key_ ? begins_[i] : i, end = key_ ? begins_[i + 1] : i + 1;
  double* into = key_ ? out.row_view(0).data() : out.all().data();
  if (key_) out.rows = static_cast<int>(end - begin);
  for (std::size_t line = begin; line < end; ++line)
    for (const Column& column : columns_) *into++ = value(line, column);
  return SourceStatus::sample;
}

}  // namespace binnacle::python
