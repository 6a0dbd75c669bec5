// SPDX-License-Identifier: Apache-2.0
#include "inspect/file_kind.hpp"

#include <zlib.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "binnacle/diagnostic.hpp"
#include "wording/special_file.hpp"

namespace binnacle::inspect {

namespace {

DataError cannot_be_opened(const std::string& path, const std::string& why) {
  return DataError(Diagnostic{binnacle::Severity::error, "B060", {path, 0, 0}, "", why});
}

std::string begin_of(const std::string& path) {
  if (std::filesystem::is_directory(path))
    throw cannot_be_opened(path, "is a folder: name its files, or a config (.json) whose sources read them");
  if (wording::is_special_file(path)) throw cannot_be_opened(path, "is not a regular file");
  const gzFile file = gzopen(path.c_str(), "rb");
  if (!file) throw cannot_be_opened(path, std::string("cannot be opened: ") + std::strerror(errno));
  std::string text(1 << 16, '\0');
  const int count = gzread(file, text.data(), static_cast<unsigned>(text.size()));
  gzclose(file);
  text.resize(static_cast<std::size_t>(std::max(count, 0)));
  return text;
}

/// A whole message of UBX: sync characters, class, identity, length, payload, Fletcher's checksum.
bool has_ubx_message(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t at = 0; (at = text.find("\xB5\x62", at)) != std::string_view::npos; ++at) {
    if (at + 8 > text.size()) return false;
    const std::size_t length = byte(at + 4) + 256U * byte(at + 5);
    if (at + 8 + length > text.size()) continue;
    unsigned a = 0, b = 0;
    for (std::size_t i = at + 2; i < at + 6 + length; ++i) {
      a = (a + byte(i)) & 255U;
      b = (b + a) & 255U;
    }
    if (a == byte(at + 6 + length) && b == byte(at + 7 + length)) return true;
  }
  return false;
}

/// "$GNGGA,…", behind a logger's stamp or not.
bool has_sentence(std::string_view line) {
  const std::size_t at = line.find('$');
  if (at == std::string_view::npos || line.size() < at + 7 || line[at + 6] != ',') return false;
  return std::ranges::all_of(line.substr(at + 1, 5),
                             [](unsigned char c) { return std::isupper(c) || std::isdigit(c); });
}

/// The line of an RTKLIB solution file that names its columns.
bool names_solution(std::string_view line) {
  if (!line.starts_with('%')) return false;
  return std::ranges::any_of(std::initializer_list<std::string_view>{"latitude(", "x-ecef(", "e-baseline("},
                             [&](std::string_view word) { return line.find(word) != std::string_view::npos; });
}

bool is_binary(std::string_view text) {
  const auto is_control = [](unsigned char c) { return c < 32 && !std::isspace(c); };
  return text.find('\0') != std::string_view::npos || 20 * std::ranges::count_if(text, is_control) > std::ssize(text);
}

}  // namespace

FileKind kind_of_file(const std::string& path) {
  const std::string begin = begin_of(path);
  if (has_ubx_message(begin)) return FileKind::ublox;
  if (is_binary(begin)) return FileKind::binary;
  std::size_t lines = 0, sentences = 0;
  std::string_view rest = begin;
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (lines == 0 && line.find("RINEX VERSION / TYPE") != std::string_view::npos) return FileKind::rinex;
    if (names_solution(line)) return FileKind::rtklib_pos;
    ++lines;
    sentences += has_sentence(line);
  }
  return 2 * sentences > lines ? FileKind::nmea : FileKind::text;
}

}  // namespace binnacle::inspect
