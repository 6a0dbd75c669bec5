// SPDX-License-Identifier: Apache-2.0
#include "column_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cells.hpp"

namespace binnacle::csv {

using Value = ParameterValue;

namespace {

std::vector<std::string> local_names() {
  return {"north", "east", "down", "up", "v_north", "v_east", "v_down", "v_up"};
}

ParameterSpec missing_spec() {
  return parameter::list("missing", parameter::text("value"))
      .about(
          "cells that mean \"no data\" and give NaN, for example \"-9999\", \"nan\", \"\"; numbers match in any "
          "notation");
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

std::size_t index_by_number(const std::string& number, const FirstRow& first, const std::string& pointer) {
  std::size_t index = 0;
  const auto [rest, error] = std::from_chars(number.data(), number.data() + number.size(), index);
  if (error != std::errc() || rest != number.data() + number.size() || index < 1 || index > first.cells.size())
    throw ComponentError("'" + number + "' is not a column: without header, columns are numbers from 1 to " +
                             std::to_string(first.cells.size()),
                         pointer);
  return index - 1;
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

FieldKind kind_of(const std::string& text) {
  return text == "rate" ? FieldKind::rate : text == "increment" ? FieldKind::increment : FieldKind::level;
}

/// "column", "unit", "missing", and how numbers are scaled: what each column has.
std::vector<ParameterSpec> cell_members(const std::string& default_name) {
  return {parameter::text("column").about(
              "name of the column in the header, or its number from 1 without a header; default: " + default_name),
          parameter::number("unit", "*")
              .required()
              .about("unit of the numbers in the file, for example \"deg/s\", \"g\", \"m\", \"1\""),
          parameter::number("scale", "1")
              .about("factor on the numbers, applied first: -1 reverses an axis, 0.061 converts counts to degrees"),
          parameter::number("offset", "*").about("offset added after the factor: a quantity of the column's dimension"),
          missing_spec()};
}

void read_scaling(const Value& value, const std::string& pointer, Column& column) {
  const Value& unit = *member(value, "unit");
  column.scale = unit.number;
  if (const Value* scale = member(value, "scale")) {
    if (scale->number == 0) throw ComponentError("'scale' is 0, which makes every number 0", pointer + "/scale");
    column.scale *= scale->number;
  }
  const Value* offset = member(value, "offset");
  if (!offset) return;
  if (offset->text != unit.text && offset->text != "1")
    throw ComponentError("'offset' has the unit " + offset->text + ", and the column is in " + unit.text,
                         pointer + "/offset");
  column.offset = offset->number;
}

Column read_cell(const std::string& name, const Value& value, const FirstRow& first, const Format& format,
                 const std::string& pointer) {
  const Value* given = member(value, "column");
  Column column;
  column.name = given ? given->text : name;
  column.index = find_column(column.name, format, first, pointer + "/column");
  column.missing = read_missing(value);
  read_scaling(value, pointer, column);
  return column;
}

/// One of three local columns, or of the vertical ones that of the two which is there; `sign`: -1 where it is up.
Column read_local_column(const Value& local, const std::string& name, const std::string& other, const FirstRow& first,
                         const Format& format, double& sign) {
  const Value* given = member(local, name);
  const Value* const opposite = other.empty() ? nullptr : member(local, other);
  const std::string either = name + (other.empty() ? "" : "' or '" + other);
  if (given && opposite)
    throw ComponentError("'" + name + "' and '" + other + "' are the same axis", "/local/" + other);
  if (!given && !opposite) throw ComponentError("'" + either + "' is missing: local axes are three", "/local");
  const std::string& key = given ? name : other;
  Column column = read_cell(key, given ? *given : *opposite, first, format, "/local/" + key);
  const Value& unit = *member(given ? *given : *opposite, "unit");
  const std::string wanted = key.starts_with("v_") ? "m/s" : "m";
  if (unit.text != wanted)
    throw ComponentError("'" + key + "' is in " + wanted + "; found the unit " + unit.text, "/local/" + key + "/unit");
  sign = given ? 1 : -1;
  return column;
}

}  // namespace

ParameterSpec column_spec() {
  auto members = cell_members("the field's name");
  members.insert(members.begin() + 2, parameter::choice("kind", {"level", "rate", "increment"})
                                          .defaults("\"level\"")
                                          .about("level: value at the sample's time; rate: mean over the interval that "
                                                 "ends there; increment: integral over this interval"));
  return parameter::object("field", std::move(members));
}

ParameterSpec local_spec() {
  return parameter::map("local", parameter::object("axis", cell_members("the axis's name")))
      .about(
          "columns in local axes: north, east and down or up, m; v_north, v_east and v_down or v_up, m/s; converted to "
          "lat, lon, height and vn, ve, vd");
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
    throw ComponentError("column '" + name + "' appears in the header twice", pointer);
  return static_cast<std::size_t>(found - cells.begin());
}

std::size_t find_column(const std::string& name, const Format& format, const FirstRow& first,
                        const std::string& pointer) {
  return format.has_header ? index_in_header(name, first, pointer) : index_by_number(name, first, pointer);
}

FieldSpec read_column(const std::string& field, const Value& value, const FirstRow& first, Layout& layout) {
  const Value* kind = member(value, "kind");
  Column column = read_cell(field, value, first, layout.format, "/columns/" + escaped(field));
  FieldSpec spec;
  spec.name = field;
  spec.unit = member(value, "unit")->text;
  spec.kind = kind ? kind_of(kind->text) : FieldKind::level;
  spec.text = "column " + column.name;
  column.kind = spec.kind;
  layout.has_intervals |= spec.kind != FieldKind::level;
  layout.columns.push_back(std::move(column));
  return spec;
}

void read_local(const Parameters& parameters, const FirstRow& first, Layout& layout, std::vector<FieldSpec>& fields) {
  if (!parameters.has("local")) return;
  Value local;
  local.members = parameters.members("local");
  for (const auto& [key, value] : local.members)
    if (const auto names = local_names(); std::ranges::find(names, key) == names.end()) {
      const std::string near = closest(key, names);
      throw ComponentError("'" + key + "' is not a local axis; " +
                               (near.empty() ? "they are: " + list_of(names) : "did you mean '" + near + "'?"),
                           "/local/" + escaped(key));
    }
  LocalColumns turned{local_axes_of(parameters, "local columns", "/local"), layout.columns.size()};
  const auto add = [&](const char* name, const char* other, double& sign, FieldSpec field) {
    for (const FieldSpec& before : fields)
      if (before.name == field.name)
        throw ComponentError("'" + field.name + "' is in 'columns' too, but 'local' computes it", "/local");
    layout.columns.push_back(read_local_column(local, name, other, first, layout.format, sign));
    field.text += ", from local columns";
    fields.push_back(std::move(field));
  };
  double same = 1;
  add("north", "", same, field::level("lat", "rad").about("geodetic latitude"));
  add("east", "", same, field::level("lon", "rad").about("longitude, east positive"));
  add("down", "up", turned.down_sign, field::level("height", "m").about("height above the ellipsoid"));
  for (const auto& [key, value] : local.members) turned.has_velocity |= key.starts_with("v_");
  if (turned.has_velocity) {
    add("v_north", "", same, field::level("vn", "m/s").about("north of the place"));
    add("v_east", "", same, field::level("ve", "m/s").about("east of the place"));
    add("v_down", "v_up", turned.velocity_down_sign, field::level("vd", "m/s").about("down of the place"));
  }
  layout.local = turned;
}

}  // namespace binnacle::csv
