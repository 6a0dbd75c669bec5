// SPDX-License-Identifier: Apache-2.0
#include "text_table.hpp"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string_view>

#include "binnacle/diagnostic.hpp"
#include "civil_time/utc_clock.hpp"

namespace binnacle::inspect {

namespace {

DataError fault(const std::string& path, const std::string& code, const std::string& message) {
  return DataError(Diagnostic{binnacle::Severity::error, code, {path, 0, 0}, "", message});
}

/// Lines of a file, plain or gzipped.
class Lines {
 public:
  explicit Lines(const std::string& path) : file_(gzopen(path.c_str(), "rb")) {
    if (!file_) throw fault(path, "B060", std::string("cannot be opened: ") + std::strerror(errno));
    gzbuffer(file_, 1 << 17);
  }
  ~Lines() { gzclose(file_); }
  Lines(const Lines&) = delete;
  Lines& operator=(const Lines&) = delete;

  bool next(std::string& line) {
    line.clear();
    char piece[4096];
    while (gzgets(file_, piece, sizeof piece)) {
      line += piece;
      if (line.back() == '\n') break;
    }
    if (line.empty()) return false;
    while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.pop_back();
    if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    return true;
  }
  bool is_damaged() const {
    int error = 0;
    gzerror(file_, &error);
    return error != Z_OK && error != Z_STREAM_END;
  }

 private:
  gzFile file_;
};

std::string_view trimmed(std::string_view cell) {
  while (!cell.empty() && (cell.front() == ' ' || cell.front() == '"' || cell.front() == '\t')) cell.remove_prefix(1);
  while (!cell.empty() && (cell.back() == ' ' || cell.back() == '"' || cell.back() == '\t')) cell.remove_suffix(1);
  return cell;
}

void split(std::string_view line, char delimiter, std::vector<std::string_view>& cells) {
  cells.clear();
  if (delimiter == ' ') {
    for (std::size_t at = 0; (at = line.find_first_not_of(" \t", at)) != std::string_view::npos;) {
      const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
      cells.push_back(line.substr(at, end - at));
      at = end;
    }
    return;
  }
  for (;;) {
    const std::size_t end = line.find(delimiter);
    cells.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return;
    line.remove_prefix(end + 1);
  }
}

bool is_number(std::string_view cell, double& value) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  const auto [rest, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && rest == cell.data() + cell.size();
}

/// "1,5": a number once its comma is a point.
bool is_number_with_comma(std::string_view cell, double& value) {
  const std::size_t comma = cell.find(',');
  if (comma == std::string_view::npos || comma + 1 == cell.size()) return false;
  std::string text(cell);
  text[comma] = '.';
  return is_number(text, value);
}

/// GPS time since 1980-01-06 [s], as the `csv` source counts it.
bool is_instant(std::string_view cell, double& value) {
  if (cell.size() < 10 || cell[0] < '1' || cell[0] > '2') return false;
  const auto utc = civil_time::parse_instant(cell);
  if (!utc) return false;
  static const auto clock = civil_time::UtcClock::from_week(0);
  const civil_time::Day day{std::chrono::days(*utc / civil_time::day_length)};
  value = seconds(clock.time({day, *utc % civil_time::day_length}));
  return true;
}

/// The one that cuts most lines into the same number of cells, more than one, most of them numbers.
char delimiter_of(const std::vector<std::string>& lines) {
  char best = ',';
  double best_score = 0, ignored = 0;
  std::vector<std::string_view> cells;
  for (const char delimiter : {',', ';', '\t', '|', ' '}) {
    std::map<std::size_t, int> counts;
    double all = 0, numbers = 0;
    for (const auto& line : lines) {
      split(line, delimiter, cells);
      ++counts[cells.size()];
      all += static_cast<double>(cells.size());
      for (const auto& cell : cells)
        numbers +=
            cell.empty() || is_number(cell, ignored) || (delimiter != ',' && is_number_with_comma(cell, ignored));
    }
    for (const auto& [width, count] : counts)
      if (const double score = width > 1 ? count * (0.01 + numbers / all) : 0; score > best_score) {
        best = delimiter;
        best_score = score;
      }
  }
  return best;
}

class Builder {
 public:
  explicit Builder(TextFormat format) : format_(std::move(format)) {}

  void begin(const std::vector<std::string>& first) {
    table.delimiter = format_.delimiter ? format_.delimiter : delimiter_of(first);
    std::map<std::size_t, int> widths;
    for (const auto& line : first) {
      split(line, table.delimiter, cells_);
      ++widths[cells_.size()];
    }
    std::size_t width = 0;
    for (const auto& [each, count] : widths)
      if (count >= (widths.count(width) ? widths[width] : 0)) width = each;
    table.columns.resize(width);
    if (!format_.delimiter && table.delimiter != ',') table.has_decimal_commas = has_decimal_commas(first);
    split(first.front(), table.delimiter, cells_);
    table.has_header = format_.header >= 0 ? format_.header == 1 : cells_.size() == width && is_header();
    for (std::size_t i = 0; i < width; ++i)
      table.columns[i].name = table.has_header && i < cells_.size() ? std::string(cells_[i]) : std::to_string(i + 1);
    for (std::size_t i = table.has_header ? 1 : 0; i < first.size(); ++i) add(first[i]);
  }
  void add(std::string_view line) {
    split(line, table.delimiter, cells_);
    if (cells_.size() != table.columns.size()) {
      ++table.cut_rows;
      return;
    }
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      TextColumn& column = table.columns[i];
      double value = std::numeric_limits<double>::quiet_NaN();
      if (cells_[i].empty()) {
        ++column.empty;
      } else if (!format_.delimiter && is_instant(cells_[i], value)) {
        ++column.instants;
      } else if (const bool is_number = is_value(cells_[i], value); !is_number || !std::isfinite(value)) {
        ++column.bad;
        column.spoilt += !is_number;
        value = std::numeric_limits<double>::quiet_NaN();
      }
      column.values.push_back(value);
    }
  }
  TextTable table;

 private:
  bool is_value(std::string_view cell, double& value) const {
    return is_number(cell, value) || (table.has_decimal_commas && is_number_with_comma(cell, value));
  }
  bool has_decimal_commas(const std::vector<std::string>& lines) {
    double ignored = 0;
    std::size_t commas = 0, points = 0;
    for (const auto& line : lines) {
      split(line, table.delimiter, cells_);
      for (const auto& cell : cells_) {
        commas += is_number_with_comma(cell, ignored);
        points += is_number(cell, ignored) && cell.find('.') != std::string_view::npos;
      }
    }
    return commas > points;
  }
  bool is_header() const {
    double ignored = 0;
    int words = 0;
    for (const auto& cell : cells_) words += !cell.empty() && !is_value(cell, ignored) && !is_instant(cell, ignored);
    return 2 * words > static_cast<int>(cells_.size());
  }

  TextFormat format_;
  std::vector<std::string_view> cells_;
};

}  // namespace

TextTable read_text_table(const std::string& path, const TextFormat& format) {
  Lines lines(path);
  Builder builder(format);
  std::vector<std::string> first;
  std::string line;
  bool has_begun = false;
  const auto begin = [&] {
    builder.begin(first);
    has_begun = true;
  };
  std::string comment = format.comment;
  while (lines.next(line)) {
    if (!format.delimiter && !has_begun && first.empty() && line.starts_with('%')) comment = "%";
    if (line.empty() || (!comment.empty() && line.starts_with(comment))) continue;
    if (has_begun) {
      builder.add(line);
    } else {
      first.push_back(line);
      if (first.size() == 50) begin();
    }
  }
  if (!has_begun && !first.empty()) begin();
  if (lines.is_damaged()) throw fault(path, "B061", "gzip data are damaged");
  const bool has_numbers = std::ranges::any_of(builder.table.columns, [](const TextColumn& column) {
    return std::ranges::any_of(column.values, [](double value) { return std::isfinite(value); });
  });
  if (!has_numbers) throw fault(path, "B066", "there are no rows of numbers");
  builder.table.comment = comment;
  return std::move(builder.table);
}

}  // namespace binnacle::inspect
