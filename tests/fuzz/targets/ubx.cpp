// SPDX-License-Identifier: Apache-2.0
// The first byte says whether the rest is taken as it is, or its frames get right checksums: few changed frames have them.
#include "../reader.hpp"
#include "../readers/ubx_bytes.hpp"
#include "ublox/ublox_source.hpp"

void binnacle::fuzz::try_bytes(std::string_view bytes) {
  if (bytes.empty()) return;
  std::string frames(bytes.substr(1));
  if (bytes.front() % 2 == 0) frames = test::ubx_with_right_checksums(frames);
  read_file<ublox::UbloxSource>("rover.ubx", frames, {});
}
