// SPDX-License-Identifier: Apache-2.0
// A target whose bytes say what becomes of a good file: what is large, or held together by checksums, is hardly reached else.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace binnacle::fuzz {

/// Each four bytes are an offset (24 bits, little-endian; beyond the end: from the beginning again) and what is XORed there.
/// An offset of 0xFFFFFF cuts the rest off at the place that the group before it was about.
inline std::string edited(std::string good, std::string_view edits) {
  std::size_t place = 0;
  for (; edits.size() >= 4 && !good.empty(); edits.remove_prefix(4)) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(edits[i]); };
    const std::size_t offset =
        byte(0) | static_cast<std::size_t>(byte(1)) << 8 | static_cast<std::size_t>(byte(2)) << 16;
    if (offset == 0xFFFFFF) {
      good.resize(place);
      continue;
    }
    place = offset % good.size();
    good[place] = static_cast<char>(good[place] ^ edits[3]);
  }
  return good;
}

}  // namespace binnacle::fuzz
