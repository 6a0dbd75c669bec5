// SPDX-License-Identifier: Apache-2.0
// The head of a RINEX file: version, type, and labelled lines.
#pragma once

#include <string>
#include <string_view>

#include "text/text_file.hpp"

namespace binnacle::rinex {

enum class FileType { observation, navigation };

struct Version {
  double number = 0;  // 2.10, 3.04
  int major() const noexcept { return static_cast<int>(number); }
};

/// The label of a header line: columns 61 to 80.
std::string_view label(std::string_view line);

/// Reads the first line. Throws ComponentError::in_data if it is no RINEX 2 or 3 file of this type.
Version read_version(text_file::LineReader& reader, const std::string& path, FileType type);

/// Opens a file as far as its first line, to report early what can be reported.
void check_file(const std::string& path, FileType type);

}  // namespace binnacle::rinex
