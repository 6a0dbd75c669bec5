// SPDX-License-Identifier: Apache-2.0
// The csv source: recorded samples from delimited text, plain or gzipped.
#include "csv_source.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "cells.hpp"

namespace binnacle::csv {

namespace {

using Value = ParameterValue;

ParameterSpec missing_spec() {
  return parameter::list("missing", parameter::text("value"))
      .about(
          "cells that mean \"no data\"; the field is then NaN. Numbers match in any spelling: \"-9999\", \"nan\", "
          "\"\"");
}

ParameterSpec column_spec() {
  return parameter::object(
      "field",
      {parameter::text("column").about("its name in the header, or its number from 1 without one; default: the field's "
                                       "name"),
       parameter::number("unit", "*")
           .required()
           .about("unit of the numbers in the file: \"deg/s\", \"g\", \"m\", \"1\""),
       parameter::choice("kind", {"level", "rate", "increment"})
           .defaults("\"level\"")
           .about("level: at the sample's time; rate: mean over the interval that ends there; increment: integral over "
                  "it"),
       missing_spec()});
}

ParameterSpec time_spec() {
  return parameter::object("time", {parameter::text("column").about(
                                        "its name in the header, or its number from 1; default: the first column"),
                                    parameter::number("unit", "*")
                                        .defaults("\"s\"")
                                        .about("unit of the labels: \"s\", \"ms\", \"us\", \"h\""),
                                    parameter::time("offset").defaults("0").about("added to every label")})
      .defaults("{}")
      .about("the column of time labels; a label is the end of its sample's interval");
}

ParameterSpec where_spec() {
  return parameter::object("where", {parameter::text("column").required().about(
                                         "its name in the header, or its number from 1 without one"),
                                     parameter::text("is").required().about("what stands there, to the letter")})
      .about("of a file with lines of several kinds, those to be read; others are passed over, of whatever width");
}

ParameterSpec rows_spec() {
  return parameter::object("rows", {parameter::text("key").required().about(
                                        "the field that tells the rows of a sample apart: a satellite, an anchor"),
                                    parameter::integer("max_rows")
                                        .at_least(1)
                                        .at_most(4096)
                                        .defaults("64")
                                        .about("rows that a sample may have; one with more is an error")})
      .about("consecutive lines with the same label are one sample with a row for each; every field is then per row");
}

/// As the member stands, or null.
const Value* member(const Value& object, std::string_view name) {
  for (const auto& [key, value] : object.members)
    if (key == name && value.type != Value::Type::absent) return &value;
  return nullptr;
}

std::string escaped(std::string key) {
  for (std::size_t at = 0; (at = key.find_first_of("~/", at)) != std::string::npos; at += 2)
    key.replace(at, 1, key[at] == '~' ? "~0" : "~1");
  return key;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// A header of one cell that has another separator in it: the delimiter is not what the config says.
std::string other_delimiter(const FirstRow& header) {
  if (header.cells.size() != 1) return {};
  for (const char* delimiter : {";", "\t", "|", ",", " "})
    if (header.cells.front().find(*delimiter) != std::string::npos)
      return std::string("; the header is a single cell: is the delimiter \"") +
             (*delimiter == '\t' ? "\\t" : delimiter) + "\"?";
  return {};
}

std::size_t index_in_header(const std::string& name, const FirstRow& header, const std::string& pointer) {
  const auto& cells = header.cells;
  const auto found = std::find(cells.begin(), cells.end(), name);
  if (found == cells.end()) {
    std::string message = "no column '" + name + "'";
    if (const std::string other = other_delimiter(header); !other.empty()) {
      message += other;
    } else if (header.is_numeric) {
      message += ": the first line holds numbers only; for a file without header line set \"header\": false";
    } else {
      const std::string near = closest(name, cells);
      message +=
          (near.empty() ? "; " : "; did you mean '" + near + "'? ") + std::string("the header has: ") + list_of(cells);
    }
    throw ComponentError(message, pointer);
  }
  if (std::find(found + 1, cells.end(), name) != cells.end())
    throw ComponentError("column '" + name + "' stands in the header twice", pointer);
  return static_cast<std::size_t>(found - cells.begin());
}

std::size_t index_by_number(const std::string& number, const FirstRow& first, const std::string& pointer) {
  std::size_t index = 0;
  const auto [rest, error] = std::from_chars(number.data(), number.data() + number.size(), index);
  if (error != std::errc() || rest != number.data() + number.size() || index < 1 || index > first.cells.size())
    throw ComponentError("'" + number + "' is no column: without header, columns are numbers from 1 to " +
                             std::to_string(first.cells.size()),
                         pointer);
  return index - 1;
}

std::size_t find_column(const std::string& name, const Format& format, const FirstRow& first,
                        const std::string& pointer) {
  return format.has_header ? index_in_header(name, first, pointer) : index_by_number(name, first, pointer);
}

Missing read_missing(const Value& column) {
  Missing missing;
  const Value* list = member(column, "missing");
  if (!list) return missing;
  for (const auto& element : list->elements) {
    double number = 0;
    missing.texts.push_back(element.text);
    if (parse_number(element.text, number) != CellFault::none) continue;
    if (std::isnan(number)) {
      missing.has_nan = true;
    } else {
      missing.numbers.push_back(number);
    }
  }
  return missing;
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
    throw ComponentError("'" + number + "' is no column: without header, columns are numbers from 1", "/where/column");
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

void read_time(const Parameters& parameters, const FirstRow& first, Layout& layout) {
  layout.time.name = layout.format.has_header ? first.cells.front() : "1";
  if (!parameters.has("time")) return;
  for (const auto& [key, value] : parameters.members("time")) {
    if (value.type == Value::Type::absent) continue;
    if (key == "column") {
      layout.time.name = value.text;
      layout.time.index = find_column(value.text, layout.format, first, "/time/column");
    } else if (key == "unit") {
      layout.time_unit = nanoseconds_of(value);
    } else if (key == "offset") {
      layout.time_offset = value.integer;
    }
  }
}

FieldKind kind_of(const std::string& text) {
  return text == "rate" ? FieldKind::rate : text == "increment" ? FieldKind::increment : FieldKind::level;
}

FieldSpec read_column(const std::string& field, const Value& value, const FirstRow& first, Layout& layout) {
  const Value* unit = member(value, "unit");
  const Value* name = member(value, "column");
  const Value* kind = member(value, "kind");
  Column column;
  column.name = name ? name->text : field;
  column.index = find_column(column.name, layout.format, first, "/columns/" + escaped(field) + "/column");
  column.scale = unit->number;
  column.missing = read_missing(value);
  FieldSpec spec;
  spec.name = field;
  spec.unit = unit->text;
  spec.kind = kind ? kind_of(kind->text) : FieldKind::level;
  spec.text = "column " + column.name;
  layout.has_intervals |= spec.kind != FieldKind::level;
  layout.columns.push_back(std::move(column));
  return spec;
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
  spec.parameters.push_back(parameter::path("path").required().about("the file; gzip is recognized by its content"));
  spec.parameters.push_back(
      parameter::map("columns", column_spec()).required().about("fields of the channel and the columns they stand in"));
  spec.parameters.push_back(time_spec());
  spec.parameters.push_back(
      parameter::time("interval")
          .above(0)
          .about("fixed length of the interval that a rate or increment belongs to; default: from label to label"));
  spec.parameters.push_back(parameter::time("max_gap").above(0).about(
      "a longer step between labels is reported and leaves the sample after it without interval; default: for rates "
      "and increments ten times the median step, else none"));
  spec.parameters.push_back(parameter::list("window", parameter::time("time"))
                                .about("[from, to], after the offset: only samples inside are read"));
  spec.parameters.push_back(parameter::text("delimiter")
                                .defaults("\",\"")
                                .about("character between cells; \" \" stands for any run of blanks"));
  spec.parameters.push_back(
      parameter::text("comment").defaults("\"#\"").about("lines that begin with it are skipped; \"\": none"));
  spec.parameters.push_back(parameter::boolean("header").defaults("true").about(
      "the first line names the columns; else they are numbered from 1"));
  spec.parameters.push_back(where_spec());
  spec.parameters.push_back(rows_spec());
  spec.parameters.push_back(
      parameter::choice("invalid_rows", {"error", "skip"})
          .defaults("\"error\"")
          .about("error: stop at a bad number, NaN, column count or time that does not increase; skip: leave such rows "
                 "out and report their number"));
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

CsvSource::CsvSource(const Binding& binding) {
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
  layout_.on_invalid = parameters.text("invalid_rows") == "skip" ? OnInvalid::skip : OnInvalid::error;
  if (layout_.has_intervals)
    channel.max_interval = layout_.interval.value_or(layout_.max_gap.value_or(nanoseconds_per_second));
  channel_ = declaration_.emits(std::move(channel));
  next_ = declaration_.keeps<std::uint64_t>();
}

void CsvSource::open(Reporter& reporter) { table_ = read_table(layout_, reporter); }

SourceStatus CsvSource::next(const MemoryView& bytes, SourceOutput& output) const {
  std::uint64_t& next = bytes[next_];
  if (next >= table_.times.size()) return SourceStatus::end;
  const auto row = static_cast<std::size_t>(next++);
  SampleWriter& out = output.on(channel_);
  out.t = table_.times[row];
  out.t0 = table_.starts.empty() ? no_time : table_.starts[row];
  const std::size_t width = layout_.columns.size();
  if (!layout_.rows) {
    std::copy_n(table_.values.begin() + static_cast<std::ptrdiff_t>(row * width), width, out.all().data());
    return SourceStatus::sample;
  }
  const std::size_t begin = table_.begins[row];
  const std::size_t end = row + 1 < table_.begins.size() ? table_.begins[row + 1] : table_.values.size() / width;
  out.rows = static_cast<int>(end - begin);
  std::copy_n(table_.values.begin() + static_cast<std::ptrdiff_t>(begin * width), (end - begin) * width,
              out.row_view(0).data());
  return SourceStatus::sample;
}

}  // namespace binnacle::csv
