// SPDX-License-Identifier: Apache-2.0
// A whole file as times and values: reading, checking, and what is said of faults.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
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

/// The first line of a file that is neither blank nor comment; of a file without header, the first that `where` chooses.
struct FirstRow {
  std::vector<std::string> cells;
  bool is_numeric = false;  // every cell is a number: hardly a header
};

/// Throws ComponentError::in_data when the file cannot be read or holds no line.
FirstRow read_first_row(const Format& format);

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
};

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

struct Table {
  std::vector<Time> times;
  std::vector<std::size_t> begins;  // the first line of each sample, with rows; empty: a line is a sample
  std::vector<Time> starts;         // of the intervals, no_time where there is none; empty: a table of instants
  std::vector<double> values;       // line by line, SI
};

/// Ten times the median step of at least two times: what counts as a gap where nothing else is said.
Time usual_gap(const std::vector<Time>& times);

/// Throws ComponentError::in_data at the first fault that is not to be skipped.
Table read_table(const Layout& layout, Reporter& reporter);

}  // namespace binnacle::csv
