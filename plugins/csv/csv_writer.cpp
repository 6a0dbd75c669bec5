// SPDX-License-Identifier: Apache-2.0
// The csv_writer sink: samples of a channel as delimited text, as the csv source reads it.
#include "csv_writer.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>
#include <system_error>

#include "text/numbers.hpp"

namespace binnacle::csv {

namespace {

namespace fs = std::filesystem;

FieldSpec field(const char* name, const char* unit, FieldKind kind = FieldKind::level) {
  return {name, unit, kind, true, false, "written if \"columns\" names it"};
}

/// Those that have a standard name; others are mapped to one of these by "fields".
std::vector<FieldSpec> writable_fields() {
  std::vector<FieldSpec> fields;
  for (const char* name : {"wx", "wy", "wz"}) fields.push_back(field(name, "rad/s", FieldKind::rate));
  for (const char* name : {"fx", "fy", "fz"}) fields.push_back(field(name, "m/s^2", FieldKind::rate));
  for (const char* name : {"lat", "lon"}) fields.push_back(field(name, "rad"));
  fields.push_back(field("height", "m"));
  for (const char* name : {"vn", "ve", "vd", "speed"}) fields.push_back(field(name, "m/s"));
  for (const char* name : {"roll", "pitch", "yaw", "course"}) fields.push_back(field(name, "rad"));
  for (const char* name : {"position_sd_n", "position_sd_e", "position_sd_d"}) fields.push_back(field(name, "m"));
  for (const char* name : {"velocity_sd_n", "velocity_sd_e", "velocity_sd_d"}) fields.push_back(field(name, "m/s"));
  return fields;
}

ParameterSpec written_column() {
  return parameter::object(
      "field", {parameter::text("column").about("name of the column in the header; default: the field's name"),
                parameter::number("unit", "*")
                    .required()
                    .about("unit of the numbers in the file, for example \"deg/s\", \"g\", \"m\"")});
}

/// Of a file beside the one that is written: another run may write it at the same time, from another machine too.
std::string unique_suffix() {
  std::random_device random;
  char text[32];
  std::snprintf(text, sizeof text, "%08x%08x", random(), random());
  return text;
}

std::string joined(const std::vector<FieldSpec>& fields) {
  std::string text;
  for (const auto& each : fields) text += (text.empty() ? "" : ", ") + each.name;
  return text;
}

}  // namespace

ComponentSpec CsvWriter::spec() {
  ComponentSpec spec;
  spec.type = "csv_writer";
  spec.summary = "samples of a channel as delimited text, a row for each, in the format of the csv source";
  spec.source = "RFC 4180 (text/csv)";
  spec.parameters = {
      parameter::path("path").required().about("output file; complete at the end of the run"),
      parameter::map("columns", written_column()).required().about("columns from left to right after the time"),
      parameter::text("time").defaults("\"t_s\"").about("name of the time column, in seconds"),
      parameter::time("offset").defaults("0").about("offset added to every time")};
  spec.inputs = {
      {"input", writable_fields(), false, "channel to be written; rates are means over the sample's interval"}};
  spec.example = R"json({"input": "imu", "path": "imu.csv",
    "columns": {"wx": {"column": "gx_dps", "unit": "deg/s"}, "fx": {"column": "ax_g", "unit": "g"}}})json";
  return spec;
}

CsvWriter::CsvWriter(const Binding& binding) : path_(binding.parameters().text("path")) {
  const auto fields = writable_fields();
  header_ = binding.parameters().text("time");
  offset_ = binding.parameters().time("offset");
  for (const auto& [name, value] : binding.parameters().members("columns")) {
    const std::string pointer = "/columns/" + name;
    const auto found =
        std::find_if(fields.begin(), fields.end(), [&, &key = name](const auto& f) { return f.name == key; });
    if (found == fields.end())
      throw ComponentError("there is no field '" + name + "' to write; there are " + joined(fields) +
                               " (a field of another name is mapped by \"fields\": {\"speed\": \"" + name + "\"})",
                           pointer);
    Column column{name, name, binding.field(binding.input("input"), name), 1};
    for (const auto& [key, member] : value.members) {
      if (key == "column" && member.type != ParameterValue::Type::absent) column.name = member.text;
      if (key != "unit") continue;
      if (member.text != found->unit)
        throw ComponentError("'" + name + "' is in " + found->unit + ", and this is a unit of " + member.text,
                             pointer + "/unit");
      column.unit = member.number;
    }
    header_ += "," + column.name;
    columns_.push_back(column);
  }
  if (columns_.empty()) throw ComponentError("no field is named", "/columns");
  header_ += "\n";
}

void CsvWriter::open() {
  const fs::path folder = fs::path(path_).parent_path();
  if (!folder.empty() && !fs::is_directory(folder))
    throw ComponentError("there is no folder '" + folder.string() + "'; make it first", "/path");
  std::error_code none;
  const auto status = fs::status(path_, none);
  if (fs::exists(status) && !fs::is_regular_file(status))  // which the file would replace
    throw ComponentError("'" + path_ +
                             "' is not a regular file; the sink stream/json_writer sends to devices and pipes",
                         "/path");
  text_ = header_;
}

void CsvWriter::on(Input /*from*/, const SampleView& sample) {
  const auto is_number = [&](const Column& column) { return std::isfinite(sample[column.handle]); };
  if (std::none_of(columns_.begin(), columns_.end(), is_number)) return;
  numbers::append_seconds(text_, sample.t + offset_);
  for (auto& column : columns_) {
    text_ += ',';
    if (!is_number(column)) continue;
    numbers::append_number(text_, sample[column.handle] / column.unit);
    column.has_number = true;
  }
  text_ += '\n';
}

void CsvWriter::close() {
  for (const auto& column : columns_)
    if (!column.has_number)
      throw ComponentError("no sample has a '" + column.field + "'; nothing was written", "/columns/" + column.field);
  write();
}

bool CsvWriter::exchange(StateBytes& bytes) {
  bytes.text(text_);
  for (auto& column : columns_) bytes.value(column.has_number);
  return true;
}

void CsvWriter::write() {
  const std::string temporary = path_ + ".part-" + unique_suffix();
  std::FILE* const file = std::fopen(temporary.c_str(), "wbx");
  bool is_written = file && std::fwrite(text_.data(), 1, text_.size(), file) == text_.size();
  int reason = errno;
  if (file && std::fclose(file) != 0 && is_written) {
    is_written = false;
    reason = errno;
  }
  std::error_code error(reason, std::generic_category());
  if (is_written) fs::rename(temporary, path_, error);
  if (is_written && !error) return;
  std::error_code ignored;
  if (file) fs::remove(temporary, ignored);
  throw ComponentError("'" + path_ + "' cannot be written: " + error.message(), "/path");
}

}  // namespace binnacle::csv
