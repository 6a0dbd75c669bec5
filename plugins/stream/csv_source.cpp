// SPDX-License-Identifier: Apache-2.0
#include "csv_source.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "text/trimmed.hpp"

namespace binnacle::stream {

namespace {

std::size_t number_of(const std::string& text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? number : 0;
}

}  // namespace

ComponentSpec CsvSource::spec() {
  ComponentSpec spec;
  spec.type = "csv";
  spec.summary = "live samples, one row of delimited text per line";
  spec.source = "RFC 4180 (text/csv)";
  add_parameters(spec);
  spec.parameters.push_back(
      parameter::map(
          "columns",
          field_spec(
              "column",
              "name of the column in the header, or its number from 1 without a header; default: the field's name"))
          .required()
          .about("fields of the channel and their columns"));
  spec.parameters.push_back(parameter::text("delimiter").defaults("\",\"").about("character between cells"));
  spec.parameters.push_back(
      parameter::text("comment").defaults("\"#\"").about("prefix of lines that are skipped; \"\": none"));
  spec.parameters.push_back(parameter::boolean("header").defaults("true").about(
      "true: the first line of each connection names the columns; false: columns are numbered from 1, and the first "
      "one is the time"));
  spec.example = R"json({
  "from": "file:live.csv",
  "columns": { "wx": { "column": "gx", "unit": "deg/s", "kind": "rate" } }
})json";
  spec.surroundings = R"({ "files": { "live.csv": "t,gx\n0.00,0.1\n0.01,0.2\n0.02,0.1\n" } })";
  return spec;
}

CsvSource::CsvSource(const Binding& binding) : LineSource(binding) {
  const Parameters& parameters = binding.parameters();
  const std::string& delimiter = parameters.text("delimiter");
  if (delimiter.size() != 1) throw ComponentError("a delimiter is one character, like \",\" or \";\"", "/delimiter");
  delimiter_ = delimiter[0];
  comment_ = parameters.text("comment");
  has_header_ = parameters.boolean("header");
  add_channel("", parameters.members("columns"), "column");
  if (has_header_) return;
  const bool is_default = time_key_ == "t";
  columns_->time = is_default ? 0 : number_of(time_key_) - 1;
  for (const auto& field : channels_.front().fields) columns_->fields.push_back(number_of(field.key) - 1);
  const auto is_none = [](std::size_t column) { return column + 1 == 0; };
  if (is_none(columns_->time) || std::ranges::any_of(columns_->fields, is_none))
    throw ComponentError("without a header, columns are numbers from 1", "/columns");
  columns_->is_known = true;
}

void CsvSource::split(std::string_view line) const {
  auto& cells = columns_->cells;
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= line.size(); ++count) {
    const auto end = std::min(line.find(delimiter_, begin), line.size());
    if (cells.size() <= count) cells.emplace_back();
    cells[count] = trimmed(line.substr(begin, end - begin), " \t\"");
    begin = end + 1;
  }
  cells.resize(count);
}

std::size_t CsvSource::column_of(const std::string& name) const {
  const auto& cells = columns_->cells;
  const auto found = std::ranges::find(cells, name);
  if (found == cells.end()) throw BadLine{"it should be the header, and has no column '" + name + "'"};
  return static_cast<std::size_t>(found - cells.begin());
}

void CsvSource::read_header() const {
  columns_->fields.clear();
  const bool has_t = std::ranges::find(columns_->cells, time_key_) != columns_->cells.end();
  columns_->time = has_t || time_key_ != "t" ? column_of(time_key_) : 0;
  for (const auto& field : channels_.front().fields) columns_->fields.push_back(column_of(field.key));
  columns_->is_known = true;
}

bool CsvSource::parse(std::string_view line, LineSample& sample) const {
  if (!comment_.empty() && line.starts_with(comment_)) return false;
  split(line);
  if (!columns_->is_known) {
    read_header();
    return false;
  }
  const auto& cells = columns_->cells;
  const auto most = std::max(columns_->time, *std::ranges::max_element(columns_->fields));
  if (cells.size() <= most) throw BadLine{"it has too few columns"};
  sample.t = time_of(cells[columns_->time]);
  sample.values.clear();
  for (const std::size_t column : columns_->fields) {
    const std::string& cell = cells[column];
    double value = 0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    const bool is_number = error == std::errc() && end == cell.data() + cell.size();
    sample.values.push_back(is_number ? value : std::numeric_limits<double>::quiet_NaN());
  }
  return true;
}

}  // namespace binnacle::stream
