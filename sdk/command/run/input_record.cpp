// SPDX-License-Identifier: Apache-2.0
#include "input_record.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "output.hpp"

namespace binnacle::command {

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void append_number(std::string& text, double value) {
  if (std::isnan(value)) {
    text += "null";
  } else if (std::isinf(value)) {
    text += value < 0 ? "\"-inf\"" : "\"inf\"";
  } else if (value == 0) {
    text += std::signbit(value) ? "-0.0" : "0";
  } else {
    char digits[32];
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
  }
}

std::vector<std::string> names(const ChannelDeclaration& channel, bool per_row) {
  std::vector<std::string> names;
  for (const auto& field : channel.fields)
    if (field.is_per_row == per_row) names.push_back(field.name);
  return names;
}

/// What the first line says of a channel.
Json fields_of(const ChannelDeclaration& channel) {
  Json fields{{"fields", names(channel, false)}};
  if (channel.max_rows > 0) fields["row_fields"] = names(channel, true);
  if (!channel.covariance.empty()) fields["covariance"] = channel.covariance.size();
  return fields;
}

/// Those that come of sources.
Json channels_of(const Composition& composition) {
  Json channels = Json::object();
  for (const auto& source : composition.sources())
    for (const int index : source.outputs) {
      const auto& channel = composition.channels()[static_cast<std::size_t>(index)];
      channels[channel.name] = fields_of(*channel.declaration);
    }
  return channels;
}

double number_of(const Json& json) {
  if (json.is_number()) return json.get<double>();
  if (json.is_null()) return nan;
  const double infinity = std::numeric_limits<double>::infinity();
  if (json == "inf") return infinity;
  if (json == "-inf") return -infinity;
  throw std::runtime_error("'" + json.dump() + "' is not a number");
}

void read_list(const Json& list, std::size_t count, std::vector<double>& into) {
  if (!list.is_array() || list.size() != count)
    throw std::runtime_error(fmt::format("found {} where {} numbers were expected", list.dump(), count));
  for (const Json& number : list) into.push_back(number_of(number));
}

}  // namespace

// ---- writing

InputWriter::InputWriter(const std::string& path, const Composition& composition)
    : path_(path), file_(std::fopen(path.c_str(), "we")) {
  if (!file_) throw UsageError(fmt::format("'{}' cannot be written: {}", path, std::strerror(errno)));
  for (const auto& channel : composition.channels())
    channels_.push_back(
        {"{\"channel\":" + Json(channel.name).dump(), static_cast<std::size_t>(channel.declaration->count(false)),
         static_cast<std::size_t>(channel.declaration->count(true)), channel.declaration->covariance.size()});
  line_ = Json{{"binnacle_input", 1}, {"channels", channels_of(composition)}}.dump() + "\n";
  std::fwrite(line_.data(), 1, line_.size(), file_.get());
}

void InputWriter::append_list(const double* numbers, std::size_t count) {
  line_ += '[';
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) line_ += ',';
    append_number(line_, numbers[i]);
  }
  line_ += ']';
}

void InputWriter::append_sample(const Arrival& arrival) {
  const Channel& channel = channels_[static_cast<std::size_t>(arrival.channel)];
  const SampleView& sample = *arrival.sample;
  line_ = channel.begin;
  fmt::format_to(std::back_inserter(line_), ",\"arrival\":{},\"n\":{},\"t\":{}", arrival.at, arrival.sequence,
                 sample.t);
  if (sample.t0 != no_time) fmt::format_to(std::back_inserter(line_), ",\"t0\":{}", sample.t0);
  line_ += ",\"fields\":";
  append_list(sample.fields, channel.fields);
  if (channel.row_fields > 0) {
    line_ += ",\"rows\":[";
    for (std::size_t row = 0; row < static_cast<std::size_t>(sample.rows); ++row) {
      if (row > 0) line_ += ',';
      append_list(sample.row_fields + row * channel.row_fields, channel.row_fields);
    }
    line_ += ']';
  }
  if (sample.covariance) {
    line_ += ",\"covariance\":";
    append_list(sample.covariance, channel.covariance * channel.covariance);
  }
  line_ += "}\n";
}

void InputWriter::write(const Arrival& arrival) {
  if (arrival.channel < 0)
    line_ = fmt::format("{{\"arrival\":{}}}\n", arrival.at);
  else
    append_sample(arrival);
  if (std::fwrite(line_.data(), 1, line_.size(), file_.get()) != line_.size() && error_ == 0) error_ = errno;
  if (arrival.at - flushed_ < nanoseconds_per_second) return;
  flushed_ = arrival.at;
  if (std::fflush(file_.get()) != 0 && error_ == 0) error_ = errno;
}

void InputWriter::close() {
  if (std::fclose(file_.release()) != 0 && error_ == 0) error_ = errno;
  if (error_ != 0) throw OutputError(fmt::format("'{}' has not all of the input: {}", path_, std::strerror(error_)));
}

// ---- reading

InputReader::InputReader(const std::string& path, const Composition& composition)
    : path_(path), composition_(composition), file_(path) {
  if (!file_) fail(fmt::format("cannot be opened: {}", std::strerror(errno)));
  check_head();
  has_ready_ = read(ready_);
}

void InputReader::fail(const std::string& why) const {
  throw DataError(Diagnostic{Severity::error, "B144", Origin{path_, static_cast<int>(line_), 0}, "", why});
}

void InputReader::check_head() {
  std::string text;
  std::getline(file_, text);
  line_ = 1;
  const Json head = Json::parse(text, nullptr, false);
  if (!head.is_object() || head.value("binnacle_input", 0) != 1)
    fail("is not a recorded input: its first line is not that of `run --record-input`");
  const Json own = channels_of(composition_);
  for (const auto& [name, fields] : head.at("channels").items()) {
    if (!own.contains(name)) fail(fmt::format("has channel '{}', which no source of the config emits", name));
    if (own.at(name) != fields)
      fail(fmt::format("channel '{}' had {}, and in the config it has {}", name, fields.dump(), own.at(name).dump()));
  }
}

bool InputReader::read(Sample& sample) {
  std::string text;
  if (!std::getline(file_, text)) return false;
  ++line_;
  is_cut_ = file_.eof();  // without its end: the run was killed while it was written
  if (is_cut_) return false;
  try {
    const Json line = Json::parse(text);
    sample.arrival = line.at("arrival").get<Time>();
    sample.channel = -1;
    if (!line.contains("channel")) return true;
    const std::string& name = line.at("channel").get_ref<const std::string&>();
    const auto& channels = composition_.channels();
    const auto found = std::ranges::find(channels, name, &ChannelInfo::name);
    if (found == channels.end()) fail(fmt::format("channel '{}' is not among those of the first line", name));
    const ChannelDeclaration& channel = *found->declaration;
    sample.channel = static_cast<int>(found - channels.begin());
    sample.sequence = line.at("n").get<std::int64_t>();
    sample.t = line.at("t").get<Time>();
    sample.t0 = line.value("t0", no_time);
    sample.rows = 0;
    for (auto* list : {&sample.fields, &sample.row_fields, &sample.covariance}) list->clear();
    read_list(line.at("fields"), static_cast<std::size_t>(channel.count(false)), sample.fields);
    if (channel.max_rows > 0)
      for (const Json& row : line.at("rows")) {
        if (++sample.rows > channel.max_rows) fail("has more rows than its channel");
        read_list(row, static_cast<std::size_t>(channel.count(true)), sample.row_fields);
      }
    const auto dof = channel.covariance.size();
    if (line.contains("covariance")) read_list(line.at("covariance"), dof * dof, sample.covariance);
    return true;
  } catch (const DataError&) {
    throw;
  } catch (const std::exception& error) {
    fail(fmt::format("cannot be read: {}", error.what()));
  }
}

std::string InputReader::warning() const {
  if (!is_cut_) return "";
  return fmt::format("'{}' ends in the middle of line {}; the lines before it were run", path_, line_);
}

bool InputReader::next_instant() {
  if (has_ready_) instant_ = ready_.arrival;
  return has_ready_;
}

const Arrival* InputReader::next() {
  while (has_ready_ && ready_.arrival == instant_) {
    std::swap(taken_, ready_);
    has_ready_ = read(ready_);
    const auto& [channel, sequence, at, t, t0, rows, fields, row_fields, covariance] = taken_;
    if (channel < 0) continue;
    view_ = {t, t0, rows, fields.data(), row_fields.data(), covariance.empty() ? nullptr : covariance.data(), true};
    given_ = {at, channel, &view_, sequence};
    return &given_;
  }
  return nullptr;
}

}  // namespace binnacle::command
