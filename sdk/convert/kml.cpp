// SPDX-License-Identifier: Apache-2.0
// KML 2.2, OGC 07-147r2, with gx:Track for times.
#include <algorithm>
#include <array>
#include <cmath>

#include "format.hpp"
#include "text.hpp"
#include "wording/markup.hpp"

namespace binnacle::convert {

namespace {

/// From small to large; aabbggrr.
constexpr std::array<const char*, 5> shades{"ff7e0d08", "ffa8317c", "ff7847cc", "ff2e88f8", "ff21f9f0"};
constexpr const char* plain = "ffb4771f";

/// Two digits.
double rounded(double value) {
  if (!(value > 0)) return 0;
  const double unit = std::pow(10, std::floor(std::log10(value)) - 1);
  return std::round(value / unit) * unit;
}

class KmlText {
 public:
  explicit KmlText(const Material& material)
      : material_(material),
        separation_(material.track.has_vertical ? material.request.geoid_separation : std::nullopt),
        decimals_(decimals_of(material.track.records)) {
    if (material.request.is_coloured) find_levels();
  }

  std::string text() {
    text_ =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" "
        "xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Document>\n<name>" +
        wording::xml(material_.title.empty() ? material_.track.filter : material_.title) + "</name>\n";
    if (!levels_.empty()) text_ += "<description>" + legend() + "</description>\n";
    style("track", plain);
    for (std::size_t i = 0; i <= levels_.size() && !levels_.empty(); ++i) style("s" + std::to_string(i), shades[i]);
    const auto& records = material_.track.records;
    if (levels_.empty()) stretch(0, records.size(), "track");
    // Stretches of one shade; each ends where the next begins, so that no gap is drawn.
    for (std::size_t begin = 0; !levels_.empty() && begin < records.size();) {
      const std::size_t shade = shade_of(records[begin]);
      std::size_t end = begin + 1;
      while (end < records.size() && shade_of(records[end]) == shade) ++end;
      stretch(begin, std::min(end + 1, records.size()), "s" + std::to_string(shade));
      begin = end;
    }
    return text_ + "</Document>\n</kml>\n";
  }

 private:
  void find_levels() {
    if (material_.track.kind == PositionKind::ecef)
      throw Refusal(
          "--colour: the filter's sigma is along x, y and z, and its covariance is not recorded; none is horizontal");
    std::vector<double> sigma;
    for (const Record& record : material_.track.records)
      if (std::isfinite(record.horizontal_sigma())) sigma.push_back(record.horizontal_sigma());
    if (sigma.empty()) throw Refusal("--colour: the run's results have no sigma of the position");
    std::sort(sigma.begin(), sigma.end());
    for (std::size_t i = 1; i < shades.size(); ++i) {
      const double level = rounded(sigma[(sigma.size() - 1) * i / shades.size()]);
      if (level > (levels_.empty() ? 0 : levels_.back())) levels_.push_back(level);
    }
    if (levels_.empty()) throw Refusal("--colour: the sigma of the position is 0 throughout");
  }

  std::size_t shade_of(const Record& record) const {
    const double sigma = record.horizontal_sigma();
    std::size_t i = 0;
    while (i < levels_.size() && !(sigma <= levels_[i])) ++i;
    return i;
  }

  std::string legend() const {
    std::string text = "horizontal 1-sigma of the filter, from dark to bright: ";
    for (const double level : levels_) {
      text += "up to ";
      append_exact(text, level);
      text += " m, ";
    }
    return text + "above";
  }

  void style(const std::string& id, const char* colour) {
    text_ += "<Style id=\"" + id + "\"><IconStyle><scale>0</scale></IconStyle><LineStyle><color>" + colour +
             "</color><width>3</width></LineStyle></Style>\n";
  }

  void coordinate(const Record& record, char between) {
    append_fixed(text_, degrees(record.lon), 9);
    text_ += between;
    append_fixed(text_, degrees(record.lat), 9);
    text_ += between;
    append_fixed(text_, separation_ ? record.height - *separation_ : 0, 3);
  }

  void stretch(std::size_t begin, std::size_t end, const std::string& style) {
    const auto& records = material_.track.records;
    text_ +=
        "<Placemark><name>" + wording::xml(material_.track.filter) + "</name><styleUrl>#" + style + "</styleUrl>\n";
    text_ += material_.time ? "<gx:Track>" : "<LineString>";
    text_ += separation_ ? "<altitudeMode>absolute</altitudeMode>\n" : "<altitudeMode>clampToGround</altitudeMode>\n";
    if (material_.time) {
      for (std::size_t i = begin; i < end; ++i)
        text_ += "<when>" + iso(material_.time->clock.utc(records[i].t), decimals_) + "</when>\n";
      for (std::size_t i = begin; i < end; ++i) {
        text_ += "<gx:coord>";
        coordinate(records[i], ' ');
        text_ += "</gx:coord>\n";
      }
      text_ += "</gx:Track></Placemark>\n";
      return;
    }
    text_ += "<coordinates>\n";
    for (std::size_t i = begin; i < end; ++i) {
      coordinate(records[i], ',');
      text_ += '\n';
    }
    text_ += "</coordinates></LineString></Placemark>\n";
  }

  const Material& material_;
  std::optional<double> separation_;
  int decimals_;
  std::vector<double> levels_;
  std::string text_;
};

}  // namespace

std::string kml(const Material& material) { return KmlText(material).text(); }

}  // namespace binnacle::convert
