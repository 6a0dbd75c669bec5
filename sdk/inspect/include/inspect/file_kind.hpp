// SPDX-License-Identifier: Apache-2.0
// What a file is by its content: receivers' files are often called .log, .txt, .bin.
#pragma once

#include <string>

namespace binnacle::inspect {

enum class FileKind { text, ublox, nmea, rtklib_pos, rinex, binary };

/// By the first 64 KiB, plain or gzipped. Throws DataError (B060) where the file cannot be opened or is a folder.
FileKind kind_of_file(const std::string& path);

}  // namespace binnacle::inspect
