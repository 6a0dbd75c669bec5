// SPDX-License-Identifier: Apache-2.0
// What a csv source reads of its file, as its config has it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/spec.hpp"
#include "binnacle/time.hpp"
#include "calendar_time.hpp"
#include "local_columns.hpp"

namespace binnacle::csv {

/// Of a file with lines of several kinds, those that are read: the ones that have this text in this cell.
struct Where {
  std::size_t index = 0;
  std::string name;  // of the column, as the header or the config calls it
  std::string text;
};

/// How the lines of a file are cut into cells.
struct Format {
  std::string path;
  char delimiter = ',';
  std::string comment;  // a line that begins with it is skipped; "": none is
  bool has_header = true;
  bool has_decimal_comma = false;
  std::optional<Where> where;  // the header is always read
};

/// Cells that stand for "no data": as text, and where the text is a number also any other spelling of it.
struct Missing {
  std::vector<std::string> texts;
  std::vector<double> numbers;
  bool has_nan = false;
};

struct Column {
  std::string name;  // as the header or the config calls it
  std::size_t index = 0;
  FieldKind kind = FieldKind::level;
  double scale = 1;   // to SI
  double offset = 0;  // SI, added afterwards
  Missing missing;

  /// A number of the file. Without an offset a zero keeps its sign.
  double in_si(double value) const {
    const double scaled = value * scale;
    return offset == 0 ? scaled : scaled + offset;
  }
};

/// Labels and times are at most this far from zero: then every difference of two of them is a number.
constexpr Time farthest_time = (Time{1} << 62) - 1;  // 146 years

constexpr bool is_near(Time t) { return t >= -farthest_time && t <= farthest_time; }

enum class OnInvalid { error, skip };

/// Consecutive lines with one label are the rows of one sample.
struct RowLayout {
  std::size_t key = 0;  // which of Layout::columns tells the rows of a sample apart
  int most = 0;         // lines that a sample may have
};

struct Layout {
  Format format;
  Column time;                                      // scale unused
  std::int64_t time_unit = nanoseconds_per_second;  // ns
  Time time_offset = 0;
  std::optional<CalendarTime> calendar;  // else labels are numbers
  int every = 1;                         // samples that become one
  std::vector<Column> columns;
  std::optional<LocalColumns> local;  // what the last of the columns become
  std::size_t width = 0;              // of the rows of a file without header
  std::optional<RowLayout> rows;
  bool has_intervals = false;    // some column is a rate or increment
  std::optional<Time> interval;  // fixed; else from label to label
  std::optional<Time> max_gap;
  Time from = std::numeric_limits<Time>::min();
  Time to = std::numeric_limits<Time>::max();
  OnInvalid on_invalid = OnInvalid::error;
};

/// How much of a file is in memory at a time. Tests have small ones.
struct Limits {
  std::size_t window = 256 * 1024;                 // bytes of text that are read at once
  std::size_t block = 256 * 1024;                  // bytes of a block's samples
  std::size_t resident = 40 * 1024 * 1024;         // bytes of samples that stay; more are read again, block by block
  std::size_t step_values = std::size_t{1} << 16;  // steps of time that are counted each by itself
};

}  // namespace binnacle::csv
