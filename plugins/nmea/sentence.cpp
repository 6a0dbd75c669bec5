// SPDX-License-Identifier: Apache-2.0
#include "sentence.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace binnacle::nmea {

namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Digits with at most one point.
bool is_decimal(std::string_view field) {
  return std::any_of(field.begin(), field.end(), is_digit) && std::count(field.begin(), field.end(), '.') <= 1 &&
         std::all_of(field.begin(), field.end(), [](char c) { return is_digit(c) || c == '.'; });
}

}  // namespace

SentenceFault parse(std::string_view line, Sentence& sentence) {
  const auto begin = line.rfind('$');
  if (begin == line.npos) return SentenceFault::no_sentence;
  line.remove_prefix(begin + 1);
  while (!line.empty() && (line.back() == '\r' || line.back() == '\n' || line.back() == ' ')) line.remove_suffix(1);
  const auto star = line.find('*');
  if (star == line.npos || line.size() < star + 3) return SentenceFault::cut;
  const int high = hex_digit(line[star + 1]), low = hex_digit(line[star + 2]);
  if (line.size() != star + 3 || high * 16 + low != checksum(line.substr(0, star))) return SentenceFault::checksum;
  line = line.substr(0, star);
  sentence.count = 0;
  for (;;) {
    const auto comma = line.find(',');
    if (sentence.count < Sentence::most_fields) sentence.fields[sentence.count++] = line.substr(0, comma);
    if (comma == line.npos) break;
    line.remove_prefix(comma + 1);
  }
  const auto address = sentence.fields[0];
  // Of proprietary sentences only the attitude that many manufacturers send: its first field is a time.
  const bool is_attitude = address == "PASHR" && !sentence[1].empty() && is_decimal(sentence[1]);
  if (address.size() != 5 || (address[0] == 'P' && !is_attitude)) return SentenceFault::no_sentence;
  sentence.talker = address.substr(0, 2);
  sentence.type = address.substr(2);
  return SentenceFault::none;
}

bool parse_number(std::string_view field, std::optional<double>& value) {
  value.reset();
  if (field.empty()) return true;
  double number = 0;
  const auto [rest, error] =
      std::from_chars(field.data(), field.data() + field.size(), number, std::chars_format::fixed);
  if (error != std::errc() || rest != field.data() + field.size() || !std::isfinite(number)) return false;
  value = number;
  return true;
}

bool parse_signed(std::string_view field, std::optional<double>& value) {
  if (field.starts_with('+')) field.remove_prefix(1);
  return parse_number(field, value);
}

bool parse_time_of_day(std::string_view field, std::optional<Time>& value) {
  value.reset();
  if (field.empty()) return true;
  if (field.size() < 6 || !is_decimal(field) || field.substr(0, 6).find('.') != field.npos) return false;
  if (field.size() > 6 && field[6] != '.') return false;
  const auto two = [&](std::size_t at) { return (field[at] - '0') * 10 + (field[at + 1] - '0'); };
  const int h = two(0), m = two(2), s = two(4);
  const bool may_be_leap = h == 23 && m == 59;
  if (h > 23 || m > 59 || s > (may_be_leap ? 60 : 59)) return false;
  Time fraction = 0;
  Time place = nanoseconds_per_second / 10;
  for (std::size_t i = 7; i < field.size(); ++i, place /= 10) fraction += (field[i] - '0') * place;
  value = (h * 3600 + m * 60 + s) * nanoseconds_per_second + fraction;
  return true;
}

bool parse_coordinate(std::string_view field, std::string_view sign, std::optional<double>& value) {
  value.reset();
  if (field.empty() && sign.empty()) return true;
  if (sign.size() != 1 || !is_decimal(field)) return false;
  const bool is_latitude = sign == "N" || sign == "S";
  if (!is_latitude && sign != "E" && sign != "W") return false;
  const std::size_t degree_digits = is_latitude ? 2 : 3;
  const auto point = std::min(field.find('.'), field.size());
  if (point != degree_digits + 2) return false;
  std::optional<double> degrees, minutes;
  if (!parse_number(field.substr(0, degree_digits), degrees) || !parse_number(field.substr(degree_digits), minutes))
    return false;
  const double all = *degrees + *minutes / 60;
  if (*minutes >= 60 || all > (is_latitude ? 90 : 180)) return false;
  value = (sign == "S" || sign == "W" ? -all : all) * degree;
  return true;
}

}  // namespace binnacle::nmea
