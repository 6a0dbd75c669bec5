// SPDX-License-Identifier: Apache-2.0
// Lines as they come: JSON, columns, NMEA and u-blox messages of a live source, chosen by the first byte.
#include "../reader.hpp"
#include "nmea/nmea_source.hpp"
#include "stream/csv_source.hpp"
#include "stream/json_source.hpp"
#include "ublox/ublox_source.hpp"

namespace binnacle::fuzz {

namespace {

using nlohmann::json;

template <class SourceType>
void read_stream(std::string_view bytes, json parameters) {
  static const test::Folder folder;
  parameters["from"] = "file:" + folder.write("live", std::string(bytes));
  try {
    const test::Recorded<SourceType> read(parameters);
  } catch (const ComponentError&) {
  }
}

}  // namespace

void try_bytes(std::string_view bytes) {
  if (bytes.empty()) return;
  const json field = {{"unit", "deg/s"}, {"kind", "rate"}};
  const std::string_view lines = bytes.substr(1);
  switch (static_cast<unsigned char>(bytes.front()) % 5) {
    case 0: return read_stream<stream::JsonSource>(lines, {{"fields", {{"wx", field}, {"wy", field}}}});
    case 1:
      return read_stream<stream::JsonSource>(
          lines,
          {{"channels", {{"imu", {{"fields", {{"wx", field}}}}}, {"gnss", {{"fields", {{"x", {{"unit", "m"}}}}}}}}}});
    case 2: return read_stream<stream::CsvSource>(lines, {{"columns", {{"wx", field}}}});
    case 3: return read_stream<nmea::NmeaSource>(lines, json::object());
    default: return read_stream<ublox::UbloxSource>(lines, json::object());
  }
}

}  // namespace binnacle::fuzz
