// SPDX-License-Identifier: Apache-2.0
// GPX 1.1, topografix.com/GPX/1/1.
#include "format.hpp"
#include "text.hpp"
#include "wording/markup.hpp"

namespace binnacle::convert {

std::string gpx(const Material& material) {
  const bool has_height = material.track.has_vertical && material.request.geoid_separation.has_value();
  const double separation = has_height ? *material.request.geoid_separation : 0;
  const int decimals = decimals_of(material.track.records);
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"binnacle export\" "
      "xmlns=\"http://www.topografix.com/GPX/1/1\">\n";
  if (!material.title.empty()) text += "<metadata><name>" + wording::xml(material.title) + "</name></metadata>\n";
  text += "<trk><name>" + wording::xml(material.track.filter) + "</name><trkseg>\n";
  for (const Record& record : material.track.records) {
    text += "<trkpt lat=\"";
    append_fixed(text, degrees(record.lat), 9);
    text += "\" lon=\"";
    append_fixed(text, degrees(record.lon), 9);
    text += "\">";
    if (has_height) {
      text += "<ele>";
      append_fixed(text, record.height - separation, 3);
      text += "</ele>";
    }
    if (material.time) text += "<time>" + iso(material.time->clock.utc(record.t), decimals) + "</time>";
    if (has_height) {
      text += "<geoidheight>";
      append_fixed(text, separation, 3);
      text += "</geoidheight>";
    }
    text += "</trkpt>\n";
  }
  return text + "</trkseg></trk>\n</gpx>\n";
}

}  // namespace binnacle::convert
