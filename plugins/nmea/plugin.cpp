// SPDX-License-Identifier: Apache-2.0
// The nmea plugin: its components.
#include "binnacle/plugin.hpp"

#include "nmea_source.hpp"
#include "nmea_writer.hpp"

BINNACLE_TYPES("nmea nmea_writer");

BINNACLE_PLUGIN("nmea", "1.0.0", registry) {
  registry.add<binnacle::nmea::NmeaSource>();
  registry.add<binnacle::nmea::NmeaWriter>();
}
