// SPDX-License-Identifier: Apache-2.0
// Rows of a file as samples, from any place on that a reader has been at: reading, checking, and what is wrong with a row.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "block.hpp"
#include "layout.hpp"
#include "plain_rows.hpp"
#include "text/text_file.hpp"

namespace binnacle::csv {

/// The first line of a file that is neither blank nor comment; of a file without header, the first that `where` chooses.
struct FirstRow {
  std::vector<std::string> cells;
  bool is_numeric = false;  // every cell is a number: hardly a header
};

/// Throws ComponentError::in_data when the file cannot be read or holds no line.
FirstRow read_first_row(const Format& format);

std::string count_of(std::size_t count, const char* thing);
std::string no_such_row(const Where& where);

/// What is wrong with one row.
struct RowFault {
  const char* code = nullptr;
  std::string message;

  explicit operator bool() const { return code != nullptr; }
};

/// What is done about it.
class RowFaults {
 public:
  virtual ~RowFaults() = default;
  virtual void refuse(const RowFault& fault, int line) = 0;
};

/// LineReader without blank lines, comments, and lines of another kind.
class Rows {
 public:
  Rows(const Format& format, const text_file::Place& from, text_file::GzipPlaces* places, std::size_t window)
      : format_(format), reader_(format.path, from, places, window) {}

  bool next(std::vector<std::string_view>& cells);
  /// Whether it is a row; then its cells.
  bool take(std::string_view line, std::vector<std::string_view>& cells) const;
  /// Of whatever kind: the header.
  bool any(std::vector<std::string_view>& cells);
  int line() const { return reader_.line(); }
  bool is_cut() const { return reader_.is_cut(); }
  text_file::Place place() const { return reader_.place(); }
  text_file::LineReader& reader() { return reader_; }

 private:
  const Format& format_;
  text_file::LineReader reader_;
};

/// What a reader of rows knows between two samples: enough to go on from there.
struct Standing {
  text_file::Place place;
  Time last_label = no_time;
  Time last_time = no_time;  // of a sample
};

class RowReader {
 public:
  /// `width`: columns of a row, where the reader does not begin at the start of the file. All of them outlive the reader.
  RowReader(const Layout& layout, const Limits& limits, const Standing& from, std::size_t width,
            text_file::GzipPlaces* places, RowFaults& faults);

  /// The next samples, `most` of them at the most; false: there are no more. Throws text_file::FileFault, and what `faults` does.
  bool fill(Block& block, std::size_t most);
  /// Before the sample that comes next.
  Standing standing() const;

  std::size_t width() const { return width_; }
  int line() const { return rows_.line(); }
  const Progress& progress() const { return progress_; }
  /// The window has ended before the file.
  bool is_done() const { return is_done_; }
  /// The last line of the file, which was read, has no end: it may be cut.
  bool is_cut() const { return rows_.is_cut(); }

 private:
  /// A row of a sample that has no place in the block any more.
  struct Pending {
    Standing standing;
    Time t = no_time;
    int line = 0;
  };

  void take_line(Block& block, std::size_t most);
  RowFault take_row(Block& block, std::size_t most);
  RowFault take_row_of(Time t, bool continues);
  void begin_sample(Block& block, Time t);
  RowFault read_label(const std::vector<std::string_view>& cells, Time& label);
  std::string_view with_point(std::string_view cell);
  RowFault take_time(Block& block, Time& label);
  RowFault take_values();
  void note(Time label);
  bool takes_back_last(Block& block, Time label);
  bool is_far_ahead(Time label);
  std::pair<Time, Time> labels_behind(Time label);

  const Layout& layout_;
  RowFaults& faults_;
  Rows rows_;
  std::optional<PlainRows> plain_;
  std::vector<std::string_view> cells_;
  std::vector<std::string> own_;  // theirs, after a look ahead
  std::vector<double> row_;
  std::string text_;                          // a number with a point for its comma
  std::vector<std::pair<double, int>> keys_;  // of the sample under way, and their lines
  Progress progress_;
  Standing before_;  // the row under way, with rows
  Pending pending_;  // t == no_time: nothing is
  std::size_t width_;
  int line_ = 0;
  bool is_skipping_;  // rows with faults
  bool is_started_;
  bool is_done_ = false;
  bool at_end_ = false;
};

}  // namespace binnacle::csv
