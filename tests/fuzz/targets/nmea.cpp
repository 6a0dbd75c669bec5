// SPDX-License-Identifier: Apache-2.0
#include "../reader.hpp"
#include "nmea/nmea_source.hpp"

void binnacle::fuzz::try_bytes(std::string_view bytes) { read_file<nmea::NmeaSource>("log.nmea", bytes, {}); }
