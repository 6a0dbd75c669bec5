// SPDX-License-Identifier: Apache-2.0
// A whole file as times and values: reading, checking, and what is said of faults.
#include "csv_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include "binnacle/parameters.hpp"
#include "cells.hpp"
#include "decimation.hpp"
#include "text/text_file.hpp"

namespace binnacle::csv {

namespace {

using text_file::FileFault;
using text_file::LineReader;

std::string count_of(std::size_t count, const char* thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

std::string quoted(std::string_view text) { return "'" + std::string(text.substr(0, 40)) + "'"; }

/// LineReader without blank lines, comments, and lines of another kind.
class Rows {
 public:
  explicit Rows(const Format& format) : format_(format), reader_(format.path) {}

  bool next(std::vector<std::string_view>& cells) {
    while (any(cells))
      if (!format_.where || is_chosen(*format_.where, cells)) return true;
    return false;
  }
  /// Of whatever kind: the header.
  bool any(std::vector<std::string_view>& cells) {
    std::string_view line;
    while (reader_.next(line)) {
      const std::size_t start = line.find_first_not_of(" \t");
      if (start == std::string_view::npos) continue;
      if (!format_.comment.empty() && line.compare(start, format_.comment.size(), format_.comment) == 0) continue;
      split(line, format_.delimiter, cells);
      return true;
    }
    return false;
  }
  int line() const { return reader_.line(); }

 private:
  static bool is_chosen(const Where& where, const std::vector<std::string_view>& cells) {
    return where.index < cells.size() && cells[where.index] == where.text;
  }

  const Format& format_;
  LineReader reader_;
};

std::string no_such_row(const Where& where) {
  return "no line has " + quoted(where.text) + " in column '" + where.name + "'";
}

/// What is wrong with one row.
struct RowFault {
  const char* code = nullptr;
  std::string message;

  explicit operator bool() const { return code != nullptr; }
};

/// "12,5" between other delimiters.
std::string comma_hint(std::string_view cell) {
  const std::size_t comma = cell.find(',');
  const bool may_be_decimal = comma != cell.npos && cell.find_first_not_of("+-0123456789,eE") == cell.npos &&
                              cell.find(',', comma + 1) == cell.npos;
  return may_be_decimal ? "; for decimal commas set \"decimal\": \",\"" : "";
}

std::string describe(CellFault fault, std::string_view cell, const char* limits) {
  switch (fault) {
    case CellFault::empty: return " is empty";
    case CellFault::out_of_range: return ": " + quoted(cell) + " is beyond " + limits;
    default: return ": " + quoted(cell) + " is not a number" + comma_hint(cell);
  }
}

bool is_missing(const Missing& missing, std::string_view cell, CellFault fault, double value) {
  if (std::find(missing.texts.begin(), missing.texts.end(), cell) != missing.texts.end()) return true;
  if (fault != CellFault::none) return false;
  if (std::isnan(value)) return missing.has_nan;
  return std::find(missing.numbers.begin(), missing.numbers.end(), value) != missing.numbers.end();
}

/// Without an offset a zero keeps its sign.
double in_si(double value, const Column& column) {
  const double scaled = value * column.scale;
  return column.offset == 0 ? scaled : scaled + column.offset;
}

class TableReader {
 public:
  TableReader(const Layout& layout, Reporter& reporter)
      : layout_(layout), reporter_(reporter), row_(layout.columns.size()) {}

  Table read() {
    std::size_t read_well = 0;
    try {
      Rows rows(layout_.format);
      if (layout_.format.has_header && rows.any(cells_)) width_ = cells_.size();
      while (rows.next(cells_)) {
        line_ = rows.line();
        if (const RowFault fault = take_row()) {
          refuse(fault);
        } else if (is_done_) {
          break;
        } else {
          ++read_well;
        }
      }
    } catch (const FileFault& fault) {
      throw ComponentError::in_data(fault.what() + ("; " + count_of(read_well, "row")) + " could be read before",
                                    layout_.format.path, 0, fault.code);
    }
    report_skipped();
    require_samples();
    set_intervals();
    if (layout_.every > 1) thin_out(layout_, table_);
    return std::move(table_);
  }

 private:
  struct Skipped {
    std::size_t count = 0;
    int first_line = 0;
    std::string first_message;
  };

  RowFault take_row() {
    const bool is_first = width_ == 0;
    if (is_first) width_ = std::max(layout_.width, cells_.size());
    if (cells_.size() != width_)
      return {"B062", count_of(cells_.size(), "column") + " where the " +
                          (layout_.format.has_header ? "header"
                           : is_first                ? "second row"
                                                     : "first row") +
                          " has " + std::to_string(width_)};
    Time label = 0;
    if (RowFault fault = take_time(label)) return fault;
    const Time t = label + layout_.time_offset;
    if (t > layout_.to) {
      is_done_ = true;
      return {};
    }
    if (t < layout_.from) {
      last_label_ = label;
      return {};
    }
    if (RowFault fault = take_values()) return fault;
    const bool continues = layout_.rows && !table_.times.empty() && table_.times.back() == t;
    if (layout_.rows)
      if (RowFault fault = take_row_of(t, continues)) return fault;
    last_label_ = label;
    if (!continues) {
      table_.times.push_back(t);
      lines_.push_back(line_);
    }
    table_.values.insert(table_.values.end(), row_.begin(), row_.end());
    return {};
  }

  /// The line as one more row of the sample at t, or as the first of a new one.
  RowFault take_row_of(Time t, bool continues) {
    const std::size_t width = row_.size(), taken = table_.values.size() / width;
    const Column& column = layout_.columns[layout_.rows->key];
    const double key = row_[layout_.rows->key];
    if (std::isnan(key)) return {"B062", "column '" + column.name + "', the key of the rows, is missing"};
    if (!continues) {
      table_.begins.push_back(taken);
      keys_.clear();
    }
    for (const auto& [other, line] : keys_)
      if (other == key)
        return {"B062", "column '" + column.name + "': " + std::string(cells_[column.index]) + " occurs twice at " +
                            time_text(t) + ", first in line " + std::to_string(line)};
    if (static_cast<int>(keys_.size()) >= layout_.rows->most)
      return {"B062", "more than " + count_of(static_cast<std::size_t>(layout_.rows->most), "row") + " at " +
                          time_text(t) + ": raise rows/max_rows if that many are right"};
    keys_.emplace_back(key, line_);
    return {};
  }

  RowFault read_label(Time& label) {
    const std::string_view cell = cells_[layout_.time.index];
    const bool has_comma = layout_.format.has_decimal_comma;
    CellFault fault = CellFault::none;
    if (layout_.calendar) {
      const CalendarTime& calendar = *layout_.calendar;
      const bool is_number = calendar.form == CalendarTime::Form::week_and_seconds;
      std::string flaw = calendar.read(is_number && has_comma ? with_point(cell) : cell, layout_.time.name,
                                       cells_[calendar.other], layout_.time_unit, label);
      if (!flaw.empty()) return {"B062", std::move(flaw)};
    } else {
      fault = parse_time(has_comma ? with_point(cell) : cell, layout_.time_unit, label);
    }
    Time shifted = 0;
    if (fault == CellFault::none && __builtin_add_overflow(label, layout_.time_offset, &shifted))
      fault = CellFault::out_of_range;
    if (fault != CellFault::none)
      return {"B062", "time column '" + layout_.time.name + "'" + describe(fault, cell, "+-292 years")};
    return {};
  }

  /// A number with a decimal comma as one with a point; one with a point is none ("1.234" may be a thousand).
  std::string_view with_point(std::string_view cell) {
    if (cell.find('.') != cell.npos) return "no number";
    text_.assign(cell);
    std::ranges::replace(text_, ',', '.');
    return text_;
  }

  RowFault take_time(Time& label) {
    if (RowFault fault = read_label(label)) return fault;
    if (label_min_ == no_time) label_min_ = label;
    label_max_ = std::max(label_max_, label);
    if (last_label_ != no_time && (layout_.rows ? label < last_label_ : label <= last_label_))
      return {"B063", std::string(layout_.rows ? "time goes back: " : "time does not increase: ") + time_text(label) +
                          " after " + time_text(last_label_)};
    return {};
  }

  RowFault take_values() {
    const bool has_comma = layout_.format.has_decimal_comma;
    for (std::size_t i = 0; i < layout_.columns.size(); ++i) {
      const Column& column = layout_.columns[i];
      const std::string_view cell = cells_[column.index];
      double value = 0;
      const CellFault fault = parse_number(has_comma ? with_point(cell) : cell, value);
      if (fault == CellFault::none && std::isfinite(value) && column.missing.numbers.empty()) {
        row_[i] = in_si(value, column);
        continue;
      }
      if (is_missing(column.missing, cell, fault, value)) {
        row_[i] = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      if (fault != CellFault::none)
        return {"B062", "column '" + column.name + "'" + describe(fault, cell, "the range of a double")};
      if (!std::isfinite(value)) return {"B064", "column '" + column.name + "' is " + std::string(cell)};
      row_[i] = in_si(value, column);
    }
    if (layout_.local && !layout_.local->turn(row_))
      return {"B062", "the local position is more than 10 000 km from the origin"};
    return {};
  }

  void refuse(const RowFault& fault) {
    if (layout_.on_invalid == OnInvalid::error)
      throw ComponentError::in_data(fault.message, layout_.format.path, line_, fault.code);
    Skipped& skipped = skipped_[fault.code];
    if (skipped.count++ == 0) {
      skipped.first_line = line_;
      skipped.first_message = fault.message;
    }
  }

  void report_skipped() {
    for (const auto& [code, skipped] : skipped_)
      reporter_.warn(code, layout_.format.path, skipped.first_line,
                     count_of(skipped.count, "row") + " skipped" + (skipped.count == 1 ? ": " : ", the first: ") +
                         skipped.first_message);
  }

  void require_samples() {
    if (!table_.times.empty()) return;
    std::string message = "no rows after the header";
    if (layout_.format.where && label_min_ == no_time && skipped_.empty()) message = no_such_row(*layout_.format.where);
    if (!skipped_.empty()) {
      message = "no rows left: every one in the window was skipped";
    } else if (label_min_ != no_time) {
      message = "no rows in the window; times run from " + time_text(label_min_ + layout_.time_offset) + " to " +
                time_text(label_max_ + layout_.time_offset) + (is_done_ ? " and on" : "");
    }
    throw ComponentError::in_data(message, layout_.format.path, 0, "B066");
  }

  void set_intervals() {
    const auto& times = table_.times;
    const bool wants_default = !layout_.max_gap && layout_.has_intervals && times.size() > 1;
    const Time max_gap = layout_.max_gap ? *layout_.max_gap
                         : wants_default ? usual_gap(times)
                                         : std::numeric_limits<Time>::max();
    if (layout_.has_intervals) {
      table_.starts.resize(times.size());
      table_.starts[0] = layout_.interval ? times[0] - *layout_.interval : no_time;
    }
    std::size_t gaps = 0, first = 0, longest = 0;
    Time length = 0, total = 0;
    for (std::size_t i = 1; i < times.size(); ++i) {
      const Time step = times[i] - times[i - 1];
      const bool is_gap = step > max_gap;
      if (layout_.has_intervals)
        table_.starts[i] = is_gap ? no_time : layout_.interval ? times[i] - *layout_.interval : times[i - 1];
      if (!is_gap) continue;
      if (gaps++ == 0) first = i;
      total += step;
      if (step > length) {
        length = step;
        longest = i;
      }
    }
    if (gaps > 0) report_gaps(gaps, max_gap, total, first, longest);
  }

  void report_gaps(std::size_t gaps, Time max_gap, Time total, std::size_t first, std::size_t longest) {
    const auto& times = table_.times;
    const Time length = times[longest] - times[longest - 1];
    std::string message = count_of(gaps, "gap") + " longer than " + time_text(max_gap);
    if (gaps == 1) {
      message += ": " + time_text(length) + " from " + time_text(times[first - 1]) + " to " + time_text(times[first]);
    } else {
      message += ", " + time_text(total) + " in all; the first from " + time_text(times[first - 1]) + " to " +
                 time_text(times[first]) + "; the longest, " + time_text(length) + ", ends at line " +
                 std::to_string(lines_[longest]);
    }
    reporter_.warn("B065", layout_.format.path, lines_[first], message);
  }

  const Layout& layout_;
  Reporter& reporter_;
  std::vector<std::string_view> cells_;
  std::vector<double> row_;
  std::string text_;                          // a number with a point for its comma
  std::vector<int> lines_;                    // the first of each sample
  std::vector<std::pair<double, int>> keys_;  // of the sample under way, and their lines
  std::map<std::string, Skipped> skipped_;
  Table table_;
  std::size_t width_ = 0;
  int line_ = 0;
  Time last_label_ = no_time;
  Time label_min_ = no_time;
  Time label_max_ = std::numeric_limits<Time>::min();
  bool is_done_ = false;
};

}  // namespace

FirstRow read_first_row(const Format& format) {
  try {
    Rows rows(format);
    std::vector<std::string_view> cells;
    const bool is_there = format.has_header ? rows.any(cells) : rows.next(cells);
    if (!is_there)
      throw ComponentError::in_data(format.where && rows.line() > 0 ? no_such_row(*format.where) : "the file is empty",
                                    format.path, 0, "B066");
    FirstRow row{{cells.begin(), cells.end()}, true};
    double ignored = 0;
    for (const auto cell : cells) row.is_numeric &= parse_number(cell, ignored) == CellFault::none;
    // A logger that was switched on within a line: the second row is the whole one.
    if (!format.has_header && rows.next(cells) && cells.size() > row.cells.size())
      row.cells.assign(cells.begin(), cells.end());
    return row;
  } catch (const FileFault& fault) {
    throw ComponentError::in_data(fault.what(), format.path, 0, fault.code);
  }
}

Time usual_gap(const std::vector<Time>& times) {
  std::vector<Time> steps(times.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = times[i + 1] - times[i];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return 10 * *middle;
}

Table read_table(const Layout& layout, Reporter& reporter) { return TableReader(layout, reporter).read(); }

}  // namespace binnacle::csv
