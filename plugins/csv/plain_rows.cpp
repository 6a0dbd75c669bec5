// SPDX-License-Identifier: Apache-2.0
// Rows of nothing but plain numbers, read in one go.
#include "plain_rows.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>
#include <utility>

#include "cells.hpp"

namespace binnacle::csv {

namespace {

unsigned digit_of(char c) { return static_cast<unsigned char>(c - '0'); }

/// Eight bytes as a number, the first the lowest.
std::uint64_t eight_bytes(const char* at) {
  std::uint64_t bytes;
  std::memcpy(&bytes, at, sizeof bytes);
  return bytes;
}

bool are_digits(std::uint64_t bytes) {
  constexpr std::uint64_t high = 0xF0F0F0F0F0F0F0F0, zeros = 0x3030303030303030, sixes = 0x0606060606060606;
  return ((bytes & high) ^ zeros) == 0 && (((bytes + sixes) & high) ^ zeros) == 0;
}

/// Pairs, then fours, then all eight are put together, each in one multiplication.
std::uint64_t number_of(std::uint64_t digits) {
  constexpr std::uint64_t mask = 0x000000FF000000FF, hundred = 100 + (std::uint64_t{1'000'000} << 32),
                          one = 1 + (std::uint64_t{10'000} << 32);
  digits -= 0x3030303030303030;
  digits = digits * 10 + (digits >> 8);
  return ((digits & mask) * hundred + ((digits >> 16) & mask) * one) >> 32;
}

/// The exponent behind an 'e'.
const char* scan_exponent(const char* at, int& exponent) {
  const bool is_negative = *at == '-';
  if (is_negative || *at == '+') ++at;
  const char* const start = at;
  int given = 0;
  for (; digit_of(*at) <= 9 && at - start < 4; ++at) given = given * 10 + static_cast<int>(digit_of(*at));
  if (at == start || digit_of(*at) <= 9) return nullptr;
  exponent += is_negative ? -given : given;
  return at;
}

}  // namespace

const char* PlainNumber::scan(const char* at) {
  constexpr std::ptrdiff_t most_digits = 19;
  negative = *at == '-';
  at += negative;
  const char* const start = at;
  std::uint64_t number = 0;
  unsigned digit = 0;
  for (; (digit = digit_of(*at)) <= 9; ++at) number = number * 10 + digit;
  std::ptrdiff_t count = at - start;
  if (count == 0) return nullptr;
  exponent = 0;
  if (*at == '.') {
    const char* const fraction = ++at;
    if constexpr (std::endian::native == std::endian::little)
      for (std::uint64_t bytes; are_digits(bytes = eight_bytes(at)); at += 8)
        number = number * 100'000'000 + number_of(bytes);
    for (; (digit = digit_of(*at)) <= 9; ++at) number = number * 10 + digit;
    count += at - fraction;
    exponent = -static_cast<int>(std::min<std::ptrdiff_t>(at - fraction, most_digits));
  }
  if (count > most_digits) return nullptr;
  digits = number;
  return *at == 'e' || *at == 'E' ? scan_exponent(at + 1, exponent) : at;
}

bool PlainNumber::convert(double& value) const {
  if (digits > (std::uint64_t{1} << 53) || exponent < -22 || exponent > 22) return false;
  const auto whole = static_cast<double>(digits);
  // Both are exact, so that one operation rounds correctly (Clinger, PLDI 1990).
  value = exponent < 0 ? whole / exact_powers_of_ten[static_cast<std::size_t>(-exponent)]
                       : whole * exact_powers_of_ten[static_cast<std::size_t>(exponent)];
  if (negative) value = -value;
  return true;
}

bool PlainRows::suit(const Layout& layout) {
  const auto is_of_numbers = [](char c) {
    return std::string_view("0123456789+-eE \r").find(c) != std::string_view::npos;
  };
  const Format& format = layout.format;
  return !layout.calendar && !layout.rows && !format.where && !format.has_decimal_comma &&
         !is_of_numbers(format.delimiter) && (format.comment.empty() || !is_of_numbers(format.comment[0]));
}

PlainRows::PlainRows(const Layout& layout, std::size_t width)
    : layout_(layout),
      delimiter_(layout.format.delimiter),
      comment_(layout.format.comment.empty() ? '\n' : layout.format.comment[0]),
      cells_(width),
      row_(layout.columns.size()) {
  if (layout.time.index < width) cells_[layout.time.index].is_time = true;
  for (std::size_t i = 0; i < layout.columns.size(); ++i)
    if (layout.columns[i].index < width) cells_[layout.columns[i].index].columns.push_back(i);
  std::int64_t unit = layout.time_unit;
  for (auto& each : nanoseconds_) {
    each = unit;
    unit = unit % 10 == 0 ? unit / 10 : 0;
  }
}

void PlainRows::take(text_file::LineReader& reader, Progress& progress, Block& block, std::size_t most) {
  const std::string_view text = reader.ahead();
  const char* at = text.data();
  const char* const end = at + text.size();
  int lines = 0;
  while (at != end && block.size() < most) {
    Time label = 0, t = 0;
    const char* const next = read_row(at, label);
    if (!next || !is_near(label) || __builtin_add_overflow(label, layout_.time_offset, &t) || !is_near(t)) break;
    if ((progress.last_label != no_time && label <= progress.last_label) || t > layout_.to) break;
    if (t >= layout_.from) {
      if (layout_.local && !layout_.local->turn(row_)) break;
      block.times.push_back(t);
      block.lines.push_back(reader.line() + lines + 1);
      block.values.insert(block.values.end(), row_.begin(), row_.end());
      progress.last_time = t;
    }
    if (progress.label_min == no_time) progress.label_min = label;
    progress.label_max = std::max(progress.label_max, label);
    progress.before_label = std::exchange(progress.last_label, label);
    ++progress.rows;
    at = next;
    ++lines;
  }
  reader.pass(static_cast<std::size_t>(at - text.data()), lines);
}

const char* PlainRows::read_row(const char* at, Time& label) {
  if (*at == comment_ || *at == '\n' || *at == '\r' || *at == ' ' || *at == '\t') return nullptr;
  const Cell* const last = &cells_.back();
  for (const Cell* cell = cells_.data();; ++cell) {
    at = cell->is_used() ? read_cell(at, *cell, label) : pass_cell(at);
    if (!at) return nullptr;
    if (cell == last) break;
    if (*at++ != delimiter_) return nullptr;
  }
  if (*at == '\r') ++at;
  return *at == '\n' ? at + 1 : nullptr;
}

/// What stands behind the cell; null: the row is none of these.
const char* PlainRows::read_cell(const char* at, const Cell& cell, Time& label) {
  const char* start = at;
  while (*start == ' ') ++start;
  PlainNumber number;
  const char* end = number.scan(start);
  if (!end) return read_odd_cell(at, cell, label);
  while (*end == ' ') ++end;
  if (*end != delimiter_ && *end != '\n' && *end != '\r') return read_odd_cell(at, cell, label);
  if (cell.is_time) {
    const std::int64_t unit =
        number.exponent > 0 || number.exponent < -19 ? 0 : nanoseconds_[static_cast<std::size_t>(-number.exponent)];
    std::uint64_t magnitude = 0;
    if (unit == 0 || __builtin_mul_overflow(number.digits, static_cast<std::uint64_t>(unit), &magnitude) ||
        magnitude > static_cast<std::uint64_t>(std::numeric_limits<Time>::max()))
      return read_odd_cell(at, cell, label);
    label = number.negative ? -static_cast<Time>(magnitude) : static_cast<Time>(magnitude);
    if (cell.columns.empty()) return end;
  }
  double value = 0;
  if (!number.convert(value)) return read_odd_cell(at, cell, label);
  return take_value(cell, value) ? end : nullptr;
}

/// As a cell of any row.
const char* PlainRows::read_odd_cell(const char* at, const Cell& cell, Time& label) {
  const char* const behind = pass_cell(at);
  if (!behind) return nullptr;
  const char* end = behind;
  if (*end == '\n' && end != at && end[-1] == '\r') --end;
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  const char* start = at;
  const char* stop = end;
  while (start != stop && is_blank(*start)) ++start;
  while (start != stop && is_blank(stop[-1])) --stop;
  const std::string_view text(start, static_cast<std::size_t>(stop - start));
  if (cell.is_time && parse_time(text, layout_.time_unit, label) != CellFault::none) return nullptr;
  if (cell.columns.empty()) return end;
  double value = 0;
  if (parse_number(text, value) != CellFault::none || !std::isfinite(value)) return nullptr;
  return take_value(cell, value) ? end : nullptr;
}

bool PlainRows::take_value(const Cell& cell, double value) {
  for (const std::size_t i : cell.columns) {
    const Column& column = layout_.columns[i];
    if (!column.missing.numbers.empty() &&
        std::ranges::find(column.missing.numbers, value) != column.missing.numbers.end())
      row_[i] = std::numeric_limits<double>::quiet_NaN();
    else
      row_[i] = column.in_si(value);
  }
  return true;
}

/// The delimiter or line end behind the cell; null where there are quotes, within which both mean nothing.
const char* PlainRows::pass_cell(const char* at) const {
  for (; *at != delimiter_ && *at != '\n'; ++at)
    if (*at == '"') return nullptr;
  return at;
}

}  // namespace binnacle::csv
