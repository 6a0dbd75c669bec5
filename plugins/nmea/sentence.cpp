// SPDX-License-Identifier: Apache-2.0
#include "sentence.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

namespace binnacle::nmea {

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr char hex[] = "0123456789ABCDEF";

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

std::uint8_t checksum(std::string_view body) {
  std::uint8_t sum = 0;
  for (const char c : body) sum = static_cast<std::uint8_t>(sum ^ static_cast<unsigned char>(c));
  return sum;
}

SentenceWriter::SentenceWriter(std::string& text, std::string_view talker, std::string_view type)
    : text_(text), begin_(text.size()) {
  text_ += '$';
  text_ += talker;
  text_ += type;
}

void SentenceWriter::end() {
  const auto sum = checksum(std::string_view(text_).substr(begin_ + 1));
  text_ += {'*', hex[sum >> 4], hex[sum & 15], '\r', '\n'};
}

void SentenceWriter::word(std::string_view field) {
  text_ += ',';
  text_ += field;
}

void SentenceWriter::digits(std::int64_t value, int count) {
  std::array<char, 20> all;
  for (int i = count; i-- > 0; value /= 10) all[static_cast<std::size_t>(i)] = static_cast<char>('0' + value % 10);
  text_.append(all.data(), static_cast<std::size_t>(count));
}

void SentenceWriter::number(double value, int decimals) {
  empty();
  if (!std::isfinite(value)) return;
  std::array<char, 64> all;
  const auto end = std::to_chars(all.data(), all.data() + all.size(), value, std::chars_format::fixed, decimals);
  if (end.ec == std::errc()) text_.append(all.data(), end.ptr);
}

void SentenceWriter::bearing(double angle, int decimals) {
  empty();
  if (!std::isfinite(angle)) return;
  const auto scale = static_cast<std::int64_t>(std::pow(10, decimals));
  auto units = std::llround(std::remainder(angle / degree, 360) * static_cast<double>(scale)) % (360 * scale);
  if (units < 0) units += 360 * scale;
  digits(units / scale, 3);
  text_ += '.';
  digits(units % scale, decimals);
}

void SentenceWriter::coordinate(double angle, int degree_digits, std::string_view signs) {
  empty();
  if (std::isfinite(angle)) {
    constexpr std::int64_t units_per_minute = 10'000'000, units_per_degree = 60 * units_per_minute;
    const auto units = std::llround(std::abs(angle) / degree * static_cast<double>(units_per_degree));
    digits(units / units_per_degree, degree_digits);
    digits(units % units_per_degree / units_per_minute, 2);
    text_ += '.';
    digits(units % units_per_minute, 7);
  }
  empty();
  if (std::isfinite(angle)) text_ += signs[std::signbit(angle) ? 1 : 0];
}

void SentenceWriter::time_of_day(Time of_day) {
  empty();
  const std::int64_t s = std::min<std::int64_t>(of_day / nanoseconds_per_second, 86399);
  digits(s / 3600, 2);
  digits(s / 60 % 60, 2);
  digits((of_day - (s - s % 60) * nanoseconds_per_second) / 1'000'000, 5);
  text_.insert(text_.end() - 3, '.');
}

void SentenceWriter::date(Day day) {
  const std::chrono::year_month_day date(day);
  empty();
  digits(static_cast<unsigned>(date.day()), 2);
  digits(static_cast<unsigned>(date.month()), 2);
  digits(static_cast<int>(date.year()) % 100, 2);
}

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
