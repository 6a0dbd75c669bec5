// SPDX-License-Identifier: Apache-2.0
// A text file as columns of numbers; nothing in it is an error.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace binnacle::inspect {

struct TextColumn {
  std::string name;                             // of the header, or its number from 1
  std::vector<double> values;                   // NaN where the cell is no number
  std::int64_t empty = 0, bad = 0, spoilt = 0;  // spoilt: bad, and not "nan" either
  std::int64_t instants = 0;  // cells that are a date and a time of day (ISO 8601): GPS time since 1980-01-06 [s]
};

struct TextTable {
  char delimiter = ',';
  bool has_header = true, has_decimal_commas = false;
  std::string comment = "#";
  std::vector<TextColumn> columns;
  std::int64_t cut_rows = 0;
};

struct TextFormat {
  char delimiter = 0;  // 0: found out
  std::string comment = "#";
  int header = -1;  // 1: there is one; 0: none; -1: found out
};

/// Where the delimiter is found out, so are decimal commas, and "%" as what comments begin with.
/// Throws DataError: B060 where it cannot be opened, B066 where there are no rows of numbers.
TextTable read_text_table(const std::string& path, const TextFormat& format = {});

}  // namespace binnacle::inspect
