// SPDX-License-Identifier: Apache-2.0
#include "sentences/sentence_writer.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <numbers>

namespace binnacle::sentences {

namespace {

constexpr double degree = std::numbers::pi / 180;
constexpr char hex[] = "0123456789ABCDEF";

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

}  // namespace binnacle::sentences
