// SPDX-License-Identifier: Apache-2.0
// NMEA 0183, by the code of the sink nmea_writer.
#include "format.hpp"
#include "sentences/motion_report.hpp"

namespace binnacle::convert {

std::string nmea(const Material& material) {
  using namespace sentences;
  const MotionReport report("GP", qualities[estimated],
                            material.track.has_vertical ? material.request.geoid_separation.value_or(Motion::unknown)
                                                        : Motion::unknown);
  std::vector<Type> types{Type::gga, Type::rmc};
  if (material.track.has_velocity) types.push_back(Type::vtg);
  if (material.track.has_yaw) types.push_back(Type::hdt);
  std::string text;
  for (const Record& record : material.track.records) {
    const Motion motion{material.time->clock.utc(MotionReport::rounded(record.t)),
                        record.lat,
                        record.lon,
                        record.height,
                        record.velocity[0],
                        record.velocity[1],
                        record.yaw,
                        true};
    for (const Type type : types) report.append(text, type, motion);
  }
  return text;
}

}  // namespace binnacle::convert
