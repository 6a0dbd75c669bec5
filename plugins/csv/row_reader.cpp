// SPDX-License-Identifier: Apache-2.0
// Rows of a file as samples: reading, checking, and what is wrong with a row.
#include "row_reader.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "binnacle/parameters.hpp"
#include "cells.hpp"

namespace binnacle::csv {

namespace {

using text_file::FileFault;

std::string shortened_in_quotes(std::string_view text) { return "'" + std::string(text.substr(0, 40)) + "'"; }

bool is_chosen(const Where& where, const std::vector<std::string_view>& cells) {
  return where.index < cells.size() && cells[where.index] == where.text;
}

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
    case CellFault::out_of_range: return ": " + shortened_in_quotes(cell) + " is beyond " + limits;
    default: return ": " + shortened_in_quotes(cell) + " is not a number" + comma_hint(cell);
  }
}

bool is_missing(const Missing& missing, std::string_view cell, CellFault fault, double value) {
  if (std::find(missing.texts.begin(), missing.texts.end(), cell) != missing.texts.end()) return true;
  if (fault != CellFault::none) return false;
  if (std::isnan(value)) return missing.has_nan;
  return std::find(missing.numbers.begin(), missing.numbers.end(), value) != missing.numbers.end();
}

RowFault far_ahead(Time label) {
  return {"B063", "time jumps ahead to " + time_text(label) + " and back: the following rows are before it"};
}

}  // namespace

std::string count_of(std::size_t count, const char* thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

std::string no_such_row(const Where& where) {
  return "no line has " + shortened_in_quotes(where.text) + " in column '" + where.name + "'";
}

bool Rows::next(std::vector<std::string_view>& cells) {
  while (any(cells))
    if (!format_.where || is_chosen(*format_.where, cells)) return true;
  return false;
}

bool Rows::take(std::string_view line, std::vector<std::string_view>& cells) const {
  const std::size_t start = line.find_first_not_of(" \t");
  if (start == std::string_view::npos) return false;
  if (!format_.comment.empty() && line.compare(start, format_.comment.size(), format_.comment) == 0) return false;
  split(line, format_.delimiter, cells);
  return true;
}

bool Rows::any(std::vector<std::string_view>& cells) {
  std::string_view line;
  while (reader_.next_filled(line))
    if (take(line, cells)) return true;
  return false;
}

RowReader::RowReader(const Layout& layout, const Limits& limits, const Standing& from, std::size_t width,
                     text_file::GzipPlaces* places, RowFaults& faults)
    : layout_(layout),
      faults_(faults),
      rows_(layout.format, from.place, places, limits.window),
      row_(layout.columns.size()),
      width_(width),
      is_skipping_(layout.on_invalid == OnInvalid::skip),
      is_started_(from.place.offset > 0 || !layout.format.has_header) {
  progress_.last_label = from.last_label;
  progress_.last_time = from.last_time;
}

Standing RowReader::standing() const {
  if (pending_.t != no_time) return pending_.standing;
  return {rows_.place(), progress_.last_label, progress_.last_time};
}

bool RowReader::fill(Block& block, std::size_t most) {
  block = Block();
  block.times.reserve(most);
  block.lines.reserve(most);
  block.values.reserve(most * row_.size());
  block.before = progress_.last_time;
  if (!std::exchange(is_started_, true) && rows_.any(cells_)) width_ = cells_.size();
  if (pending_.t != no_time) {
    line_ = pending_.line;
    begin_sample(block, std::exchange(pending_.t, no_time));
    block.values.insert(block.values.end(), row_.begin(), row_.end());
  }
  // The last sample of a block is one for sure when the next one follows.
  const bool reads_on = layout_.rows || is_skipping_;
  const auto wants_more = [&] { return !at_end_ && pending_.t == no_time && (reads_on || block.size() < most); };
  while (wants_more()) {
    if (!plain_ && width_ > 0 && PlainRows::suit(layout_)) plain_.emplace(layout_, width_);
    if (plain_) plain_->take(rows_.reader(), progress_, block, most);
    if (wants_more()) take_line(block, most);
  }
  return block.size() > 0;
}

void RowReader::take_line(Block& block, std::size_t most) {
  if (layout_.rows || is_skipping_) before_ = standing();
  if (!rows_.next(cells_)) {
    at_end_ = true;
    return;
  }
  line_ = rows_.line();
  if (const RowFault fault = take_row(block, most))
    faults_.refuse(fault, line_);
  else if (is_done_)
    at_end_ = true;
  else
    ++progress_.rows;
}

RowFault RowReader::take_row(Block& block, std::size_t most) {
  const bool is_first = width_ == 0;
  if (is_first) width_ = std::max(layout_.width, cells_.size());
  if (cells_.size() != width_)
    return {"B062", count_of(cells_.size(), "column") + " where the " +
                        (layout_.format.has_header ? "header"
                         : is_first                ? "second row"
                                                   : "first row") +
                        " has " + std::to_string(width_)};
  Time label = 0;
  if (RowFault fault = take_time(block, label)) return fault;
  const Time t = label + layout_.time_offset;
  if (t > layout_.to) {
    if (is_skipping_ && is_far_ahead(label)) return far_ahead(label);
    is_done_ = true;
    return {};
  }
  if (t < layout_.from) {
    note(label);
    return {};
  }
  if (RowFault fault = take_values()) return fault;
  const bool continues = layout_.rows && block.size() > 0 && block.times.back() == t;
  if (layout_.rows)
    if (RowFault fault = take_row_of(t, continues)) return fault;
  note(label);
  if (!continues && block.size() == most) {
    pending_ = {before_, t, line_};
    return {};
  }
  if (!continues) begin_sample(block, t);
  block.values.insert(block.values.end(), row_.begin(), row_.end());
  return {};
}

void RowReader::begin_sample(Block& block, Time t) {
  if (layout_.rows) block.begins.push_back(static_cast<std::uint32_t>(block.values.size() / row_.size()));
  block.times.push_back(t);
  block.lines.push_back(line_);
  progress_.last_time = t;
}

/// The line as one more row of the sample at t, or as the first of a new one.
RowFault RowReader::take_row_of(Time t, bool continues) {
  const Column& column = layout_.columns[layout_.rows->key];
  const double key = row_[layout_.rows->key];
  if (std::isnan(key)) return {"B062", "column '" + column.name + "', the key of the rows, is missing"};
  if (!continues) keys_.clear();
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

RowFault RowReader::read_label(const std::vector<std::string_view>& cells, Time& label) {
  const std::string_view cell = cells[layout_.time.index];
  const bool has_comma = layout_.format.has_decimal_comma;
  CellFault fault = CellFault::none;
  if (layout_.calendar) {
    const CalendarTime& calendar = *layout_.calendar;
    const bool is_number = calendar.form == CalendarTime::Form::week_and_seconds;
    std::string flaw = calendar.read(is_number && has_comma ? with_point(cell) : cell, layout_.time.name,
                                     cells[calendar.other], layout_.time_unit, label);
    if (!flaw.empty()) return {"B062", std::move(flaw)};
  } else {
    fault = parse_time(has_comma ? with_point(cell) : cell, layout_.time_unit, label);
  }
  Time shifted = 0;
  if (fault == CellFault::none &&
      (!is_near(label) || __builtin_add_overflow(label, layout_.time_offset, &shifted) || !is_near(shifted)))
    fault = CellFault::out_of_range;
  if (fault != CellFault::none)
    return {"B062", "time column '" + layout_.time.name + "'" + describe(fault, cell, "+-146 years")};
  return {};
}

/// A number with a decimal comma as one with a point; one with a point is none ("1.234" may be a thousand).
std::string_view RowReader::with_point(std::string_view cell) {
  if (cell.find('.') != cell.npos) return "no number";
  text_.assign(cell);
  std::ranges::replace(text_, ',', '.');
  return text_;
}

void RowReader::note(Time label) {
  if (label != progress_.last_label) progress_.before_label = std::exchange(progress_.last_label, label);
}

/// The first labels behind this row that are others, one after the other; no_time where there are none close by.
std::pair<Time, Time> RowReader::labels_behind(Time label) {
  constexpr std::size_t near = 4 * 1024;
  own_.assign(cells_.begin(), cells_.end());  // what is looked at ahead may take the place of the line
  std::string_view text = rows_.reader().look_ahead(near);
  cells_.assign(own_.begin(), own_.end());
  std::vector<Time> others;
  std::vector<std::string_view> cells;
  // Not many lines: a file may have nothing but rows that are looked behind.
  for (int lines = layout_.rows ? 64 : 4; lines > 0 && !text.empty() && others.size() < 2; --lines) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    Time next = 0;
    if (!rows_.take(line, cells) || cells.size() != width_) continue;
    if (layout_.format.where && !is_chosen(*layout_.format.where, cells)) continue;
    if (read_label(cells, next) || next == (others.empty() ? label : others.back())) continue;
    others.push_back(next);
  }
  others.resize(2, no_time);
  return {others[0], others[1]};
}

/// Of a label behind the window: the rows go on before it.
bool RowReader::is_far_ahead(Time label) {
  const auto [next, second] = labels_behind(label);
  return next != no_time && second != no_time && next < second && second < label &&
         (progress_.last_label == no_time || next > progress_.last_label);
}

/// The label is before the last one: if two rows go on where the last one jumped ahead, it is that one which is left out.
bool RowReader::takes_back_last(Block& block, Time label) {
  const Time last = progress_.last_label, before = progress_.before_label;
  const Time next = labels_behind(label).first;
  if (next == no_time || next <= label || next > last || (before != no_time && label <= before)) return false;
  const Time t = last + layout_.time_offset;
  const bool is_here = block.size() > 0 && block.times.back() == t;
  if (!is_here && t >= layout_.from) return false;
  // Of two rows behind a jump that are unusable nothing is noted, and what was before the last label is not known.
  const Time previous = is_here ? block.time_before(block.size() - 1) : no_time;
  if (previous != no_time && label + layout_.time_offset <= previous) return false;
  if (is_here) {
    const std::size_t row = block.row_begin(block.size() - 1);
    const std::size_t rows = block.values.size() / row_.size() - row;
    for (std::size_t i = 0; i < rows; ++i) faults_.refuse(far_ahead(last), block.lines.back());
    progress_.rows -= rows;
    block.values.resize(row * row_.size());
    block.times.pop_back();
    block.lines.pop_back();
    if (!block.begins.empty()) block.begins.pop_back();
    progress_.last_time = block.size() > 0 ? block.times.back() : block.before;
  }
  // Where it is not known what was before, nothing goes back before the last sample all the same.
  const Time given = progress_.last_time == no_time ? no_time : progress_.last_time - layout_.time_offset;
  progress_.last_label = std::max(before, given);
  progress_.before_label = no_time;
  return true;
}

RowFault RowReader::take_time(Block& block, Time& label) {
  if (RowFault fault = read_label(cells_, label)) return fault;
  if (progress_.label_min == no_time) progress_.label_min = label;
  progress_.label_max = std::max(progress_.label_max, label);
  const bool is_back = label < progress_.last_label && !(is_skipping_ && takes_back_last(block, label));
  if (progress_.last_label != no_time && (is_back || (!layout_.rows && label == progress_.last_label)))
    return {"B063", std::string(layout_.rows ? "time goes back: " : "time does not increase: ") + time_text(label) +
                        " after " + time_text(progress_.last_label)};
  return {};
}

RowFault RowReader::take_values() {
  const bool has_comma = layout_.format.has_decimal_comma;
  for (std::size_t i = 0; i < layout_.columns.size(); ++i) {
    const Column& column = layout_.columns[i];
    const std::string_view cell = cells_[column.index];
    double value = 0;
    const CellFault fault = parse_number(has_comma ? with_point(cell) : cell, value);
    if (fault == CellFault::none && std::isfinite(value) && column.missing.numbers.empty()) {
      row_[i] = column.in_si(value);
      continue;
    }
    if (is_missing(column.missing, cell, fault, value)) {
      row_[i] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    if (fault != CellFault::none)
      return {"B062", "column '" + column.name + "'" + describe(fault, cell, "the range of a double")};
    if (!std::isfinite(value)) return {"B064", "column '" + column.name + "' is " + std::string(cell)};
    row_[i] = column.in_si(value);
  }
  if (layout_.local && !layout_.local->turn(row_))
    return {"B062", "the local position is more than 10 000 km from the origin"};
  return {};
}

FirstRow read_first_row(const Format& format) {
  try {
    Rows rows(format, {}, nullptr, text_file::LineReader::usual_window);
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

}  // namespace binnacle::csv
