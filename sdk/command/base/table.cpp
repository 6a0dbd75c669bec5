// SPDX-License-Identifier: Apache-2.0
#include "table.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "wording/wording.hpp"

namespace binnacle::command {

namespace {

/// Characters, not bytes: "µs" is two wide.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

Table::Table(std::string alignment, int indent)
    : alignment_(std::move(alignment)), indent_(static_cast<std::size_t>(indent)) {}

void Table::row(std::vector<std::string> cells) {
  if (cells.size() > alignment_.size()) throw std::logic_error("a row has more cells than the table columns");
  for (auto& cell : cells) cell = wording::visible(cell);
  rows_.push_back(std::move(cells));
}

std::string Table::text() const {
  std::vector<std::size_t> widths(alignment_.size(), 0);
  for (const auto& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], width_of(row[i]));
  std::string text;
  for (const auto& row : rows_) {
    std::string line(indent_, ' ');
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string padding(widths[i] - width_of(row[i]), ' ');
      line += (i ? "  " : "") + (alignment_[i] == 'r' ? padding + row[i] : row[i] + padding);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string heading(const std::string& title) { return title.empty() ? "" : wording::visible(title) + "\n\n"; }

std::string joined(const std::vector<std::string>& items, std::string_view separator) {
  return fmt::format("{}", fmt::join(items, separator));
}

std::string counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string figure(double value) {
  const double magnitude = std::abs(value);
  if (!std::isfinite(value)) return std::isnan(value) ? "-" : fmt::format("{}", value);
  if (magnitude == 0) return "0";
  if (magnitude < 1e-3 || magnitude >= 1e7) return fmt::format("{:.3e}", value);
  const int decimals = std::clamp(3 - static_cast<int>(std::floor(std::log10(magnitude))), 0, 6);
  return fmt::format("{:.{}f}", value, decimals);
}

std::string duration(double seconds) {
  if (seconds < 1e-3) return figure(seconds * 1e6) + " us";
  if (seconds < 1) return figure(seconds * 1e3) + " ms";
  return figure(seconds) + " s";
}

}  // namespace binnacle::command
