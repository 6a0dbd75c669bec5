// SPDX-License-Identifier: Apache-2.0
// A channel as it was recorded: labels and fields in the order of the file, before anything is refused.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/spec.hpp"
#include "binnacle/unit.hpp"

namespace binnacle::inspect {

struct Field {
  std::string name;    // as components subscribe to it: "wx", "lat"; else as the column is called
  std::string column;  // in the file; empty: not of a text file
  std::string unit;    // of the file, as stated or guessed: "deg"; "" where nothing is known
  std::string si;      // unit of the values: "rad"
  double scale = 1;    // values = numbers in the file · scale
  FieldKind kind = FieldKind::level;
  bool is_guessed = false;          // the unit was not stated
  std::vector<double> values = {};  // NaN where the cell is no number
  std::int64_t empty = 0;           // cells without anything in them
  std::int64_t bad = 0;             // cells that are no number
  std::int64_t spoilt = 0;          // those of the bad that say something else than nan: "1.2.3"
};

struct Channel {
  std::string name;
  std::string path;     // of a text file
  std::string pointer;  // into the config, "/sources/imu"; empty: a bare file
  std::string type;     // of the source
  char delimiter = ',';
  std::string comment = "#";
  bool has_header = true, has_decimal_commas = false;
  bool has_dates = false;  // labels are dates with times of day (ISO 8601), counted as GPS time from 1980-01-06
  std::string time_column;
  std::string time_unit = "s";
  bool time_is_guessed = false;  // its unit was not stated
  double time_offset = 0;        // s, which a config adds to the labels
  double first_label = 0;        // s
  std::vector<double> t;         // s since the first label
  std::vector<Field> fields;
  std::int64_t cut_rows = 0;    // of another number of cells
  std::int64_t bad_labels = 0;  // cells of the time that are neither number nor date
  std::string fault;            // why the source itself could not be read to its end
  bool has_rows = false;        // a sample has a row for each satellite, anchor or the like: nothing in it is looked at

  const Field* find(std::string_view field) const {
    for (const Field& each : fields)
      if (each.name == field) return &each;
    return nullptr;
  }
  bool is_inertial() const { return find("wx") && find("wy") && find("wz") && find("fx") && find("fy") && find("fz"); }
  /// By its name: "truth", "reference_position". It is what others are judged by, and no fix for a filter.
  bool is_reference() const { return name.find("truth") != std::string::npos || name.starts_with("reference"); }
  bool is_fix() const { return (find("lat") && find("lon")) || (find("vn") && find("ve")); }
};

/// Reads a text file, plain or gzipped: delimiter, header, columns by name and by behaviour. Throws DataError (B060, B066).
Channel read_bare_file(const std::string& path, const std::string& name);

/// Of the numbers in a file: "deg", or a quantity that counts in others, "-1 g", "1e-7 deg". It must be one.
Unit file_unit(const std::string& text);

/// What a config says of a text file; the rows are read as they are, also those that the source would refuse.
struct StatedColumn {
  std::string field, column, unit;
  double scale = 1;
  std::string si;
  FieldKind kind = FieldKind::level;
  std::vector<std::string> missing;
};
struct StatedFile {
  std::string path, time_column, time_unit = "s";
  double time_scale = 1, time_offset = 0;  // s
  char delimiter = ',';
  std::string comment = "#";
  bool has_header = true;
  std::vector<StatedColumn> columns;
};
Channel read_stated_file(const StatedFile& file, const std::string& name);

}  // namespace binnacle::inspect
