// SPDX-License-Identifier: Apache-2.0
// The head of a RINEX file: version, type, and labelled lines.
#include "header.hpp"

#include "binnacle/parameters.hpp"
#include "columns.hpp"

namespace binnacle::rinex {

std::string_view label(std::string_view line) { return trimmed(columns(line, 60, 20)); }

Version read_version(text_file::LineReader& reader, const std::string& path, FileType type) {
  std::string_view line;
  if (!reader.next(line)) throw ComponentError::in_data("the file is empty", path, 0, "B066");
  const auto version = number(columns(line, 0, 9));
  if (label(line) != "RINEX VERSION / TYPE" || !version)
    throw ComponentError::in_data("is not a RINEX file: the first line is not that of a version", path, 1, "B062");
  if (!(*version >= 2 && *version < 4))
    throw ComponentError::in_data("RINEX version " + std::string(trimmed(columns(line, 0, 9))) +
                                      " cannot be read; 2.x and 3.x can",
                                  path, 1, "B062");
  const bool is_observation = type == FileType::observation;
  if (columns(line, 20, 1) != (is_observation ? "O" : "N"))
    throw ComponentError::in_data(std::string("is no file of ") +
                                      (is_observation ? "observations" : "GPS navigation messages") + " but of type '" +
                                      std::string(columns(line, 20, 1)) + "'",
                                  path, 1, "B062");
  return {*version};
}

void check_file(const std::string& path, FileType type) {
  try {
    text_file::LineReader reader(path);
    read_version(reader, path, type);
  } catch (const text_file::FileFault& fault) {
    throw ComponentError::in_data(fault.what(), path, 0, fault.code);
  }
}

}  // namespace binnacle::rinex
