// SPDX-License-Identifier: Apache-2.0
#include "columns.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>

namespace binnacle::report {

static_assert(std::endian::native == std::endian::little, "a page's typed arrays are little-endian");

namespace {

template <class T>
std::string_view bytes_of(const T& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])};
}

}  // namespace

std::string base64(std::string_view bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](std::size_t k) -> std::uint32_t {
      return i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u;
    };
    const std::uint32_t three = at(0) << 16 | at(1) << 8 | at(2);
    text += digits[three >> 18 & 63];
    text += digits[three >> 12 & 63];
    text += i + 1 < bytes.size() ? digits[three >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? digits[three & 63] : '=';
  }
  return text;
}

int Columns::add(const char* type, std::string_view bytes, double offset) {
  Json entry{{type, base64(bytes)}};
  if (offset != 0) entry["o"] = offset;
  const std::size_t hash = std::hash<std::string_view>()(entry[type].get_ref<const std::string&>());
  const auto [first, last] = known_.equal_range(hash);
  for (auto known = first; known != last; ++known)
    if (list_[static_cast<std::size_t>(known->second)] == entry) return known->second;
  known_.emplace(hash, static_cast<int>(list_.size()));
  list_.push_back(std::move(entry));
  return static_cast<int>(list_.size()) - 1;
}

int Columns::exact(std::span<const double> values) { return add("f8", bytes_of(values), 0); }

int Columns::bytes(std::span<const std::uint8_t> values) { return add("u1", bytes_of(values), 0); }

int Columns::plotted(std::span<const double> values) {
  double least = std::numeric_limits<double>::infinity(), greatest = -least;
  for (const double value : values)
    if (std::isfinite(value)) {
      least = std::min(least, value);
      greatest = std::max(greatest, value);
    }
  // Only what varies little about a large number (a latitude) is kept as a difference from it; elsewhere small numbers
  // would lose their digits to the offset.
  const double middle = (least + greatest) / 2;
  const double offset = std::isfinite(middle) && std::abs(middle) > greatest - least ? middle : 0;
  std::vector<float> differences;
  differences.reserve(values.size());
  for (const double value : values) differences.push_back(static_cast<float>(value - offset));
  return add("f4", bytes_of(differences), offset);
}

}  // namespace binnacle::report
