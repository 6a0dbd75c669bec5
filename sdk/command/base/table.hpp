// SPDX-License-Identifier: Apache-2.0
// Text tables: columns as wide as their widest cell, and numbers as people read them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace binnacle::command {

class Table {
 public:
  /// One character per column: 'l' left, 'r' right.
  explicit Table(std::string alignment, int indent = 2);

  /// Missing cells are empty; more than there are columns are not allowed.
  void row(std::vector<std::string> cells);
  bool empty() const { return rows_.empty(); }
  /// One line per row, nothing behind the last cell.
  std::string text() const;

 private:
  std::string alignment_;
  std::size_t indent_;
  std::vector<std::vector<std::string>> rows_;
};

/// A config's title above a text, in one line; "" where it has none.
std::string heading(const std::string& title);

/// "a, b, c"
std::string joined(const std::vector<std::string>& items, std::string_view separator = ", ");

/// "1 row", "2 rows"
std::string counted(std::size_t count, std::string_view noun);

/// Four significant digits, without an exponent where that reads better: 0.1234, 12.34, 1.234e-06; "-" for NaN.
std::string figure(double value);

/// Seconds, readable: "1.92 us", "3.4 ms", "12.5 s".
std::string duration(double seconds);

}  // namespace binnacle::command
