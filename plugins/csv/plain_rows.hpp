// SPDX-License-Identifier: Apache-2.0
// Rows of nothing but plain numbers, read in one go: the same bits as cell by cell, many times as fast.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "block.hpp"
#include "layout.hpp"
#include "text/text_file.hpp"

namespace binnacle::csv {

/// What has been read.
struct Progress {
  Time last_label = no_time;    // before the offset
  Time before_label = no_time;  // the one before that, as far as it is known
  Time last_time = no_time;     // of a sample
  Time label_min = no_time;     // of all labels, good rows or not; no_time: there were none
  Time label_max = std::numeric_limits<Time>::min();
  std::size_t rows = 0;  // good ones
};

/// A number as it stands: digits · 10^exponent.
struct PlainNumber {
  std::uint64_t digits = 0;
  int exponent = 0;
  bool negative = false;

  /// What follows the number that begins here, null where it is no plain one: more than 19 digits, or of another form. Reads
  /// up to eight bytes more than it has.
  const char* scan(const char* at);
  /// The double next to it. False: that takes more than it can do.
  bool convert(double& value) const;
};

class PlainRows {
 public:
  /// Whether rows of this layout can be plain.
  static bool suit(const Layout& layout);

  PlainRows(const Layout& layout, std::size_t width);

  /// Takes the plain rows that the reader has at hand, up to `most` samples in the block; stops before the first that is not
  /// one, for whatever reason.
  void take(text_file::LineReader& reader, Progress& progress, Block& block, std::size_t most);

 private:
  struct Cell {
    bool is_time = false;
    std::vector<std::size_t> columns;  // that it becomes

    bool is_used() const { return is_time || !columns.empty(); }
  };

  const char* read_row(const char* at, Time& label);
  const char* read_cell(const char* at, const Cell& cell, Time& label);
  const char* read_odd_cell(const char* at, const Cell& cell, Time& label);
  bool take_value(const Cell& cell, double value);
  const char* pass_cell(const char* at) const;

  const Layout& layout_;
  char delimiter_, comment_;
  std::vector<Cell> cells_;
  std::array<std::int64_t, 20> nanoseconds_{};  // of a digit with so many behind the point; 0: less than one
  std::vector<double> row_;
};

}  // namespace binnacle::csv
