// SPDX-License-Identifier: Apache-2.0
#include "csv_records.hpp"

#include <cctype>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace binnacle::command {

namespace {

constexpr std::size_t text_size = 1 << 18;

/// RFC 4180: quotes around what has a comma or quotes in it.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

constexpr int significant_of_sigma = 5;

}  // namespace

Digits digits_of(const score::RecordColumn& column) {
  if (column.name.ends_with(".sigma") || column.name.ends_with(".noise")) return {Digits::none, significant_of_sigma};
  static constexpr std::pair<std::string_view, int> decimals[] = {{"rad", 11},  {"m", 4}, {"m/s", 6}, {"rad/s", 9},
                                                                  {"m/s^2", 7}, {"1", 9}, {"s", 12}};
  for (const auto& [unit, count] : decimals)
    if (column.unit == unit) return {count};
  return {Digits::shortest};
}

std::string csv_name(const std::string& filter) {
  std::string name;
  for (const char c : filter) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_plain =
        byte >= 0x80 || std::isalnum(byte) || c == '_' || c == '-' || c == ' ' || (c == '.' && !name.empty());
    name += is_plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return name + ".csv";
}

CsvRecords::CsvRecords(std::filesystem::path path, const std::vector<score::RecordColumn>& columns)
    : file_(std::move(path)) {
  std::string header = "t[s]";
  for (const auto& column : columns) {
    header += "," + cell(column.unit.empty() ? column.name : fmt::format("{}[{}]", column.name, column.unit));
    digits_.push_back(digits_of(column));
  }
  file_.write(header + "\n");
}

void CsvRecords::write(const results::RowBlock& rows) {
  const std::size_t columns = digits_.size(), longest_row = (columns + 1) * (longest_number + 1);
  text_.resize(text_size + longest_row);
  char* const begin = text_.data();
  char* at = begin;
  const double* value = rows.values.data();
  for (const Time t : rows.t) {
    at = put_seconds(at, t);
    for (std::size_t c = 0; c < columns; ++c) {
      *at++ = ',';
      at = put_number(at, *value++, digits_[c]);
    }
    *at++ = '\n';
    if (at < begin + text_size) continue;
    file_.write({begin, at});
    at = begin;
  }
  file_.write({begin, at});
}

}  // namespace binnacle::command
