// SPDX-License-Identifier: Apache-2.0
// The csv source: recorded samples from delimited text, plain or gzipped.
#include "csv_source.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cells.hpp"
#include "column_reader.hpp"
#include "row_reader.hpp"

namespace binnacle::csv {

namespace {

using Value = ParameterValue;

ParameterSpec time_spec() {
  return parameter::object(
             "time",
             {parameter::text("column").about(
                  "name of the column in the header, or its number from 1; default: the first column"),
              parameter::number("unit", "*")
                  .defaults("\"s\"")
                  .about("unit of the labels, for example \"s\", \"ms\", \"us\", \"h\""),
              parameter::time("offset").defaults("0").about("offset added to every label"),
              parameter::choice("format", {"number", "iso8601"})
                  .defaults("\"number\"")
                  .about("iso8601: date and time in one cell, 2026-11-23T12:00:05.25+01:00, also with a blank instead "
                         "of T"),
              parameter::text("date_column").about("column of dates; 'column' then contains times of day, 12:00:05.25"),
              parameter::choice("date_order", {"ymd", "dmy", "mdy"})
                  .defaults("\"ymd\"")
                  .about("format of dates: 2026-11-23, 23.11.2026 or 11/23/2026, with - / . or nothing as separator"),
              parameter::text("week_column")
                  .about("column of GPS weeks; 'column' then contains times of the week, in 'unit'"),
              parameter::time("zone")
                  .at_least(-26 * 3600)
                  .at_most(26 * 3600)
                  .about("calendar times minus UTC, for cells without a time zone; default: UTC")})
      .defaults("{}")
      .about("column of time labels; a label is the end of its sample's interval");
}

ParameterSpec where_spec() {
  return parameter::object("where", {parameter::text("column").required().about(
                                         "name of the column in the header, or its number from 1 without a header"),
                                     parameter::text("is").required().about("exact text of the cell")})
      .about(
          "selection of lines in a file with several kinds of lines; other lines are ignored, with any number of "
          "columns");
}

ParameterSpec rows_spec() {
  return parameter::object("rows", {parameter::text("key").required().about(
                                        "field that identifies the rows of a sample, such as a satellite or an anchor"),
                                    parameter::integer("max_rows")
                                        .at_least(1)
                                        .at_most(4096)
                                        .defaults("64")
                                        .about("largest number of rows of a sample; more rows are an error")})
      .about("consecutive lines with the same label form one sample with a row each; every field is then per row");
}

Format read_format(const Parameters& parameters) {
  Format format;
  format.path = parameters.text("path");
  const std::string& delimiter = parameters.text("delimiter");
  if (delimiter.size() != 1 || delimiter == "\"" || delimiter == "." || delimiter == "\n")
    throw ComponentError("a delimiter is one character, like \",\", \";\", \"\\t\" or \" \" for any run of blanks",
                         "/delimiter");
  format.delimiter = delimiter[0];
  format.comment = parameters.text("comment");
  format.has_header = parameters.boolean("header");
  format.has_decimal_comma = parameters.has("decimal") && parameters.text("decimal") == ",";
  if (format.has_decimal_comma && format.delimiter == ',')
    throw ComponentError("decimal commas need another delimiter than \",\": \";\", \"\\t\" or \" \"", "/decimal");
  return format;
}

/// Without header before the first row is read, which it chooses; with one afterwards.
void read_where(const Parameters& parameters, const FirstRow* header, Format& format) {
  if (!parameters.has("where")) return;
  const Parameters where = parameters.object("where");
  format.where = Where{0, where.text("column"), where.text("is")};
  if (header) {
    format.where->index = index_in_header(format.where->name, *header, "/where/column");
    return;
  }
  constexpr std::size_t most = 10000;
  const std::string& number = format.where->name;
  std::size_t index = 0;
  const auto [rest, error] = std::from_chars(number.data(), number.data() + number.size(), index);
  if (error != std::errc() || rest != number.data() + number.size() || index < 1 || index > most)
    throw ComponentError("'" + number + "' is not a column: without header, columns are numbers from 1",
                         "/where/column");
  format.where->index = index - 1;
}

void read_rows(const Parameters& parameters, const ChannelDeclaration& channel, Layout& layout) {
  const Parameters rows = parameters.object("rows");
  const std::string& key = rows.text("key");
  std::vector<std::string> names;
  for (const FieldSpec& field : channel.fields) {
    names.push_back(field.name);
    if (field.kind != FieldKind::level)
      throw ComponentError("with rows every field is a level: the rows of a sample are of one instant",
                           "/columns/" + escaped(field.name) + "/kind");
  }
  const auto found = std::find(names.begin(), names.end(), key);
  if (found == names.end()) {
    const std::string near = closest(key, names);
    throw ComponentError("no field '" + key + "' among columns" +
                             (near.empty() ? "; they are: " + list_of(names) : "; did you mean '" + near + "'?"),
                         "/rows/key");
  }
  layout.rows = RowLayout{static_cast<std::size_t>(found - names.begin()), static_cast<int>(rows.integer("max_rows"))};
}

std::int64_t nanoseconds_of(const Value& unit) {
  const double length = std::min(unit.number * 1e9, 1e15);
  const std::int64_t whole = std::llround(length);
  const bool is_whole = std::abs(length - static_cast<double>(whole)) < 1e-9 * length;
  if (unit.text != "s" || !is_whole || whole > 100'000'000'000'000)
    throw ComponentError("labels need a unit of time of whole nanoseconds, like \"s\", \"ms\", \"us\", \"ns\" or \"h\"",
                         "/time/unit");
  return whole;
}

/// Where labels are no plain numbers.
void read_calendar(const Parameters& parameters, const Parameters& time, const FirstRow& first, Layout& layout) {
  using Form = CalendarTime::Form;
  const bool is_iso = time.has("format") && time.text("format") == "iso8601";
  const bool has_date = time.has("date_column"), has_week = time.has("week_column");
  const auto refuse_if = [](bool is_wrong, const std::string& message, const std::string& pointer) {
    if (is_wrong) throw ComponentError(message, pointer);
  };
  refuse_if(is_iso && (has_date || has_week), "a time of ISO 8601 has its date, and needs no other column",
            has_date ? "/time/date_column" : "/time/week_column");
  refuse_if(has_date && has_week, "there is 'date_column' too: a time is of a day or of a week", "/time/week_column");
  const bool is_calendar = is_iso || has_date, counts = is_calendar || has_week;
  refuse_if(time.has("zone") && !is_calendar,
            "a zone belongs to calendar times, which need \"format\": \"iso8601\" or a 'date_column'", "/time/zone");
  for (const char* key : {"week", "epoch", "leap_seconds"})
    refuse_if(
        parameters.has(key) && !counts,
        "it gives the origin of time for calendar times and GPS weeks, but the labels are plain numbers: see 'offset'",
        std::string("/") + key);
  if (!counts) return;
  refuse_if(is_calendar && layout.time_unit != nanoseconds_per_second, "calendar times have no unit", "/time/unit");
  CalendarTime calendar(civil_time::UtcClock{parameters});
  calendar.form = is_iso ? Form::instant : has_date ? Form::date_and_time : Form::week_and_seconds;
  if (time.has("zone")) calendar.zone = time.time("zone");
  if (!is_iso) {
    const char* const key = has_date ? "date_column" : "week_column";
    calendar.other_name = time.text(key);
    calendar.other = find_column(calendar.other_name, layout.format, first, std::string("/time/") + key);
    refuse_if(calendar.other == layout.time.index, "it is the column of times too", std::string("/time/") + key);
  }
  const std::string order = time.has("date_order") ? time.text("date_order") : "ymd";
  calendar.order = order == "dmy"   ? civil_time::DateOrder::dmy
                   : order == "mdy" ? civil_time::DateOrder::mdy
                                    : civil_time::DateOrder::ymd;
  layout.calendar = calendar;
}

void read_time(const Parameters& parameters, const FirstRow& first, Layout& layout) {
  layout.time.name = layout.format.has_header ? first.cells.front() : "1";
  const Parameters time = parameters.has("time") ? parameters.object("time") : Parameters();
  if (parameters.has("time"))
    for (const auto& [key, value] : parameters.members("time"))
      if (key == "unit" && value.type != Value::Type::absent) layout.time_unit = nanoseconds_of(value);
  if (time.has("column")) {
    layout.time.name = time.text("column");
    layout.time.index = find_column(layout.time.name, layout.format, first, "/time/column");
  }
  if (time.has("offset")) layout.time_offset = time.time("offset");
  read_calendar(parameters, time, first, layout);
}

void read_window(const Parameters& parameters, Layout& layout) {
  if (!parameters.has("window")) return;
  const auto& window = parameters.list("window");
  if (window.size() != 2 || window[0].integer >= window[1].integer)
    throw ComponentError("a window is [from, to] with from < to", "/window");
  layout.from = window[0].integer;
  layout.to = window[1].integer;
}

}  // namespace

ComponentSpec CsvSource::spec() {
  ComponentSpec spec;
  spec.type = "csv";
  spec.summary = "recorded samples from delimited text, plain or gzipped";
  spec.source = "RFC 4180 (text/csv), RFC 1952 (gzip)";
  spec.parameters.push_back(parameter::path("path").required().about("input file; gzip is recognized by its content"));
  spec.parameters.push_back(
      parameter::map("columns", column_spec()).defaults("{}").about("fields of the channel and their columns"));
  spec.parameters.push_back(local_spec());
  spec.parameters.push_back(parameter::origin());
  spec.parameters.push_back(time_spec());
  spec.parameters.push_back(
      parameter::time("interval")
          .above(0)
          .about("fixed length of the interval of a rate or increment; default: the time between labels"));
  spec.parameters.push_back(parameter::time("max_gap").above(0).about(
      "longest step between labels; a longer step is reported, and the sample after it has no interval; default: ten "
      "times the median step for rates and increments, otherwise no limit"));
  spec.parameters.push_back(parameter::list("window", parameter::time("time"))
                                .about("[from, to], after the offset; only samples inside are read"));
  spec.parameters.push_back(parameter::integer("every").at_least(1).at_most(1'000'000).defaults("1").about(
      "number of samples combined into one: the first level; the mean of rates, the sum of increments"));
  for (ParameterSpec& each : civil_time::UtcClock::parameters()) spec.parameters.push_back(std::move(each));
  spec.parameters.push_back(
      parameter::text("delimiter").defaults("\",\"").about("character between cells; \" \": one or more blanks"));
  spec.parameters.push_back(parameter::choice("decimal", {".", ","})
                                .defaults("\".\"")
                                .about("decimal separator; a comma needs another delimiter"));
  spec.parameters.push_back(
      parameter::text("comment").defaults("\"#\"").about("prefix of lines that are skipped; \"\": none"));
  spec.parameters.push_back(parameter::boolean("header").defaults("true").about(
      "true: the first line names the columns; false: columns are numbered from 1"));
  spec.parameters.push_back(where_spec());
  spec.parameters.push_back(rows_spec());
  spec.parameters.push_back(parameter::choice("invalid_rows", {"error", "skip"})
                                .defaults("\"error\"")
                                .about("error: stop at a bad number, NaN, column count or time that does not increase; "
                                       "skip: skip such rows and report their number"));
  spec.example = R"({
  "path": "imu.csv",
  "time": { "column": "t_s", "unit": "s" },
  "columns": {
    "wx": { "column": "gx", "unit": "deg/s", "kind": "rate" },
    "fx": { "column": "ax", "unit": "g", "kind": "rate" }
  },
  "max_gap": "0.1 s"
})";
  spec.surroundings =
      R"({ "files": { "imu.csv": "t_s,gx,ax\n0.00,0.1,1.0\n0.01,0.2,1.1\n0.02,0.1,1.0\n0.03,0.0,0.9\n" } })";
  return spec;
}

CsvSource::CsvSource(const Binding& binding, const Limits& limits) : limits_(limits) {
  const Parameters& parameters = binding.parameters();
  layout_.format = read_format(parameters);
  if (!layout_.format.has_header) read_where(parameters, nullptr, layout_.format);
  const FirstRow first = read_first_row(layout_.format);
  if (!layout_.format.has_header) layout_.width = first.cells.size();
  if (layout_.format.has_header) read_where(parameters, &first, layout_.format);
  read_time(parameters, first, layout_);
  ChannelDeclaration channel;
  for (const auto& [field, value] : parameters.members("columns"))
    channel.fields.push_back(read_column(field, value, first, layout_));
  read_local(parameters, first, layout_, channel.fields);
  if (channel.fields.empty()) throw ComponentError("no field is named", "/columns");
  if (parameters.has("rows")) {
    read_rows(parameters, channel, layout_);
    for (FieldSpec& field : channel.fields) field.is_per_row = true;
    channel.max_rows = layout_.rows->most;
  }
  if (parameters.has("interval")) {
    if (!layout_.has_intervals)
      throw ComponentError("an interval needs a column of kind \"rate\" or \"increment\"", "/interval");
    layout_.interval = parameters.time("interval");
  }
  if (parameters.has("max_gap")) layout_.max_gap = parameters.time("max_gap");
  read_window(parameters, layout_);
  if (parameters.has("every")) layout_.every = static_cast<int>(parameters.integer("every"));
  layout_.on_invalid = parameters.text("invalid_rows") == "skip" ? OnInvalid::skip : OnInvalid::error;
  if (layout_.has_intervals)
    channel.max_interval = layout_.every * layout_.interval.value_or(layout_.max_gap.value_or(nanoseconds_per_second));
  channel_ = declaration_.emits(std::move(channel));
  next_ = declaration_.keeps<std::uint64_t>();
}

void CsvSource::open(Reporter& reporter) { table_ = std::make_unique<Table>(layout_, limits_, reporter); }

SourceStatus CsvSource::next(const MemoryView& bytes, SourceOutput& output) const {
  std::uint64_t& next = bytes[next_];
  if (next >= table_->size()) return SourceStatus::end;
  table_->write(next, output.on(channel_));
  ++next;
  return SourceStatus::sample;
}

}  // namespace binnacle::csv
