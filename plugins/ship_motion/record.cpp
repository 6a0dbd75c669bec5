// SPDX-License-Identifier: Apache-2.0
#include "record.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "text/text_file.hpp"

namespace binnacle::ship_motion {

namespace {

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const auto comma = line.find(',');
    std::string_view cell = line.substr(0, comma);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
    cells.push_back(cell);
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

ComponentError unreadable(const text_file::FileFault& fault, const std::string& path) {
  return ComponentError::in_data(fault.what(), path, 0, fault.code);
}

/// The lines of a file that are neither blank nor comment.
class Lines {
 public:
  explicit Lines(const std::string& path) : reader_(path) {}

  bool next(std::vector<std::string_view>& cells) {
    std::string_view line;
    while (reader_.next(line))
      if (line.find_first_not_of(" \t") != std::string_view::npos && line.front() != '#') {
        cells = cells_of(line);
        return true;
      }
    return false;
  }
  int line() const { return reader_.line(); }

 private:
  text_file::LineReader reader_;
};

struct Columns {
  std::size_t time, value;
};

Columns find_columns(const RecordPlace& place, const std::vector<std::string_view>& header) {
  const auto index = [&](const std::string& name, const char* pointer) {
    const auto found = std::find(header.begin(), header.end(), name);
    if (found != header.end()) return static_cast<std::size_t>(found - header.begin());
    std::string known;
    for (const auto& cell : header) known += (known.empty() ? "" : ", ") + std::string(cell);
    throw ComponentError("no column '" + name + "'; the header has: " + known, pointer);
  };
  return {place.time_column.empty() ? 0 : index(place.time_column, "/time"), index(place.column, "/column")};
}

double number_in(const std::vector<std::string_view>& cells, std::size_t column, const RecordPlace& place, int line) {
  double value = 0;
  const std::string_view cell = column < cells.size() ? cells[column] : std::string_view();
  const auto [rest, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || rest != cell.data() + cell.size() || !std::isfinite(value))
    throw ComponentError::in_data("'" + std::string(cell) + "' is not a number", place.path, line, "B062");
  return value;
}

std::vector<std::string_view> header_of(Lines& lines, const std::string& path) {
  std::vector<std::string_view> header;
  if (!lines.next(header)) throw ComponentError::in_data("the file is empty", path, 0, "B066");
  return header;
}

}  // namespace

std::vector<ParameterSpec> RecordPlace::parameters() {
  return {parameter::path("path").required().about("comma-separated text file with a header line, plain or gzipped"),
          parameter::text("column").required().about("of the motion"),
          parameter::number("unit", "*").required().about("unit of the column's numbers, for example \"deg\""),
          parameter::text("time").about("column of the time in seconds; default: the first"),
          parameter::list("window", parameter::time("time")).about("[from, to]: only samples inside are used")};
}

RecordPlace::RecordPlace(const Parameters& owner, const std::string& si_unit, const std::string& pointer) {
  const Parameters parameters = owner.object("record");
  path = parameters.text("path");
  column = parameters.text("column");
  if (parameters.has("time")) time_column = parameters.text("time");
  unit = parameters.number("unit");
  if (parameters.has("window")) {
    const auto& window = parameters.list("window");
    if (window.size() != 2 || window[0].integer >= window[1].integer)
      throw ComponentError("a window is [from, to] with from < to", pointer + "/window");
    from = window[0].integer;
    to = window[1].integer;
  }
  for (const auto& [key, value] : owner.members("record"))
    if (key == "unit" && value.text != si_unit)
      throw ComponentError("the motion is in " + si_unit + ", the column in " + value.text, pointer + "/unit");
  try {
    Lines lines(path);
    find_columns(*this, header_of(lines, path));
  } catch (const text_file::FileFault& fault) {
    throw unreadable(fault, path);
  } catch (const ComponentError& error) {
    if (error.is_data_error()) throw;
    throw ComponentError(error.what(), pointer + error.pointer());
  }
}

Record RecordPlace::read() const {
  Record record;
  std::vector<double> values;
  try {
    Lines lines(path);
    std::vector<std::string_view> cells = header_of(lines, path);
    const Columns columns = find_columns(*this, cells);
    while (lines.next(cells)) {
      const Time t = nanoseconds(number_in(cells, columns.time, *this, lines.line()));
      if (t < from || t > to) continue;
      if (!values.empty() && t <= record.times.back())
        throw ComponentError::in_data("time does not increase", path, lines.line(), "B063");
      record.times.push_back(t);
      values.push_back(unit * number_in(cells, columns.value, *this, lines.line()));
    }
  } catch (const text_file::FileFault& fault) {
    throw unreadable(fault, path);
  }
  if (values.size() < 2) throw ComponentError::in_data("there is no motion in it", path, 0, "B066");
  record.values = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  record.mean = record.values.mean();
  record.values.array() -= record.mean;
  record.interval = seconds(record.times.back() - record.times.front()) / static_cast<double>(record.times.size() - 1);
  for (std::size_t i = 1; i < record.times.size(); ++i)
    if (const double step = seconds(record.times[i] - record.times[i - 1]);
        std::abs(step - record.interval) > 0.3 * record.interval)
      throw ComponentError::in_data("a step of " + std::to_string(step) + " s where the mean is " +
                                        std::to_string(record.interval) + " s; a spectrum needs even sampling",
                                    path, 0, "B065");
  return record;
}

}  // namespace binnacle::ship_motion
