// SPDX-License-Identifier: Apache-2.0
#include "sample_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "fixture.hpp"

namespace binnacle::conform {

namespace {

constexpr int rows_made_up = 4;

std::string in_marks(const std::string& name) { return "'" + name + "'"; }

bool is_numbers(const Json& value) {
  return value.is_array() && !value.empty() &&
         std::all_of(value.begin(), value.end(), [](const Json& element) { return element.is_number(); });
}

/// What is wrong with {field: number or list} under `where`.
std::string wrong_numbers(const Json& given, const std::vector<FieldSpec>& fields, const std::string& where) {
  if (!given.is_object()) return where + " is not an object of fields and numbers, but " + given.dump();
  std::size_t rows = 0;
  for (const auto& [name, value] : given.items()) {
    const auto field = std::ranges::find(fields, name, &FieldSpec::name);
    const std::string at = where + "." + name;
    if (field == fields.end()) return at + ": the spec has no such field";
    if (value.is_number()) continue;
    if (!field->is_per_row) return at + " is to be a number in SI, and is " + value.dump();
    if (!is_numbers(value)) return at + " is to be a number in SI or a list of one per row, and is " + value.dump();
    if (rows != 0 && value.size() != rows)
      return at + " has " + std::to_string(value.size()) + " rows, and another field " + std::to_string(rows);
    rows = value.size();
  }
  return "";
}

int rows_of(const std::vector<FieldSpec>& fields, const Json& given) {
  const bool has_rows = std::any_of(fields.begin(), fields.end(), [](const auto& f) { return f.is_per_row; });
  for (const auto& value : given)
    if (value.is_array()) return static_cast<int>(value.size());
  return has_rows ? rows_made_up : 0;
}

}  // namespace

double scale_of(const std::string& unit) {
  struct Scale {
    const char* unit;
    double size;
  };
  for (const Scale& scale : {Scale{"rad", 0.2}, Scale{"m", 10}, Scale{"m/s", 3}, Scale{"rad/s", 0.05},
                             Scale{"m/s^2", 0.5}, Scale{"1", 0.01}, Scale{"s", 1e-6}})
    if (unit == scale.unit) return scale.size;
  return 1;
}

SampleView SampleNumbers::view() const {
  SampleView view;
  if (!is_available) return view;
  view.t = t;
  view.t0 = t - 10'000'000;
  view.rows = rows;
  view.fields = epoch.data();
  view.row_fields = row.data();
  view.covariance = covariance.empty() ? nullptr : covariance.data();
  view.available = true;
  return view;
}

Surroundings::Surroundings(const ComponentSpec& spec) {
  if (spec.surroundings.empty()) return;
  const Json all = Json::parse(spec.surroundings, nullptr, true, true);
  sample_ = all.value("sample", Json::object());
  inputs_ = all.value("inputs", Json::object());
  if (all.contains("time")) time_ = static_cast<Time>(std::llround(all.at("time").get<double>() * 1e9));
}

std::string wrong_shape(const ComponentSpec& spec) {
  if (spec.surroundings.empty()) return "";
  const Json all = Json::parse(spec.surroundings, nullptr, false, true);
  if (!all.is_object()) return "its surroundings are no JSON object";
  const std::set<std::string> known = {"blocks", "sources", "sample", "inputs", "time", "files"};
  for (const auto& item : all.items())
    if (!known.contains(item.key()))
      return "its surroundings have a key " + in_marks(item.key()) + " that means nothing";
  if (all.contains("time") && !all.at("time").is_number())
    return "its surroundings: time is to be a number of seconds, and is " + all.at("time").dump();
  if (all.contains("sample"))
    if (auto wrong = wrong_numbers(all.at("sample"), spec.fields, "its surroundings: sample"); !wrong.empty())
      return wrong;
  if (!all.contains("inputs")) return "";
  if (!all.at("inputs").is_object()) return "its surroundings: inputs is not an object of inputs and their fields";
  for (const auto& [name, given] : all.at("inputs").items()) {
    const auto input = std::ranges::find(spec.inputs, name, &ChannelPort::name);
    if (input == spec.inputs.end()) return "its surroundings: inputs." + name + ": the spec has no such input";
    if (auto wrong = wrong_numbers(given, input->fields, "its surroundings: inputs." + name); !wrong.empty())
      return wrong;
  }
  return "";
}

SampleNumbers made_up(const std::vector<FieldSpec>& fields, const std::vector<bool>& has, const Json& given, Time t,
                      std::mt19937_64& random, double spread) {
  SampleNumbers numbers;
  numbers.t = t;
  numbers.rows = rows_of(fields, given);
  std::vector<std::vector<double>> columns;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const double made = spread * scale_of(fields[i].unit) * normal(random);
    double value = has[i] ? made : std::numeric_limits<double>::quiet_NaN();
    const Json entry = given.value(fields[i].name, Json());
    if (entry.is_number()) value = entry.get<double>();
    if (!fields[i].is_per_row) {
      numbers.epoch.push_back(value);
    } else if (entry.is_array()) {
      columns.push_back(entry.get<std::vector<double>>());
    } else {
      columns.emplace_back();
      const double change = entry.is_number() ? 0 : 0.01;  // a number that was given stands for all rows
      for (int r = 0; r < numbers.rows; ++r) columns.back().push_back(value * (1 + change * r));
    }
  }
  for (int r = 0; r < numbers.rows; ++r)
    for (const auto& column : columns) numbers.row.push_back(column[static_cast<std::size_t>(r)]);
  return numbers;
}

void number_rows(SampleNumbers& numbers, const std::vector<FieldSpec>& fields, const Json& given) {
  const auto width = static_cast<std::size_t>(
      std::count_if(fields.begin(), fields.end(), [](const FieldSpec& field) { return field.is_per_row; }));
  std::size_t column = 0;
  for (const FieldSpec& field : fields) {
    if (!field.is_per_row) continue;
    if (field.unit == "1" && !given.contains(field.name))
      for (std::size_t row = 0; row < static_cast<std::size_t>(numbers.rows); ++row)
        numbers.row[row * width + column] = static_cast<double>(row + 1);
    ++column;
  }
}

}  // namespace binnacle::conform
