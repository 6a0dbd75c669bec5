// SPDX-License-Identifier: Apache-2.0
// The nmea_writer sink: a position, velocity and heading as sentences of NMEA 0183.
#include "nmea_writer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sentence.hpp"

namespace binnacle::nmea {

namespace {

constexpr double knot = 1852.0 / 3600.0;  // [m/s]
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

struct Quality {
  const char* name;
  char gga;
  char mode;
};
constexpr std::array<Quality, 7> qualities{{{"autonomous", '1', 'A'},
                                            {"differential", '2', 'D'},
                                            {"rtk", '4', 'R'},
                                            {"float", '5', 'F'},
                                            {"estimated", '6', 'E'},
                                            {"manual", '7', 'M'},
                                            {"simulator", '8', 'S'}}};

constexpr std::array<const char*, 4> type_names{"GGA", "RMC", "VTG", "HDT"};

std::vector<std::string> quality_names() {
  std::vector<std::string> names;
  for (const Quality& quality : qualities) names.emplace_back(quality.name);
  return names;
}

std::vector<ParameterSpec> parameters() {
  using namespace parameter;
  auto specs = text_output::TextOutput::parameters();
  specs.push_back(
      list("sentences", choice("sentence", {type_names.begin(), type_names.end()}))
          .about("in this order for each sample; default: of GGA, RMC, VTG, HDT those whose fields there are"));
  specs.push_back(text("talker").defaults("\"GP\"").about("the first two letters of each sentence: GP, GN, IN …"));
  specs.push_back(choice("quality", quality_names())
                      .defaults("\"estimated\"")
                      .about("what GGA (6 for estimated), RMC and VTG (E) say of a valid position"));
  specs.push_back(number("max_sigma", "m")
                      .above(0)
                      .about("with a larger horizontal 1-sigma, sqrt(north^2 + east^2) of the channel's covariance, "
                             "the position is not valid; "
                             "default: every finite one is"));
  specs.push_back(
      number("geoid_separation", "m")
          .about("height of the geoid above the ellipsoid: GGA gives heights above the sea. Without it GGA has "
                 "no height"));
  for (ParameterSpec& spec : UtcClock::parameters()) specs.push_back(std::move(spec));
  return specs;
}

}  // namespace

ComponentSpec NmeaWriter::spec() {
  using field::level;
  ComponentSpec spec;
  spec.type = "nmea_writer";
  spec.summary = "position, velocity and heading as sentences of NMEA 0183: GGA, RMC, VTG, HDT";
  spec.source = "NMEA 0183 version 4.11; IEC 61162-1";
  spec.parameters = parameters();
  spec.inputs = {input("input", {level("lat", "rad").optional().about("geodetic latitude, WGS-84"),
                                 level("lon", "rad").optional().about("longitude, east positive"),
                                 level("height", "m").optional().about("above the ellipsoid"),
                                 level("vn", "m/s").optional().about("velocity over ground, north"),
                                 level("ve", "m/s").optional().about("velocity over ground, east"),
                                 level("yaw", "rad").optional().about("heading, from true north to east")})
                     .about("what is written; \"fields\": {\"lat\": \"position.lat\", …} maps a filter's estimates")};
  spec.example = R"json({"input": "ins", "to": "tcp://:10110", "epoch": "2026-11-23T12:00:00Z",
    "geoid_separation": "47.5 m",
    "fields": {"lat": "position.lat", "lon": "position.lon", "height": "position.height",
               "vn": "velocity.vn", "ve": "velocity.ve", "yaw": "attitude.yaw"}})json";
  return spec;
}

NmeaWriter::NmeaWriter(const Binding& binding)
    : output_(binding.parameters()),
      clock_(binding.parameters()),
      talker_(binding.parameters().text("talker")),
      position_(binding.fields(binding.input("input"), "lat", "lon", "height")),
      velocity_(binding.fields(binding.input("input"), "vn", "ve")),
      yaw_(binding.field(binding.input("input"), "yaw")) {
  const Parameters& p = binding.parameters();
  if (!p.has("week") && !p.has("epoch"))
    throw ComponentError(
        "sentences carry UTC: give 'week', the GPS week at whose begin time is zero (0: seconds since 1980-01-06), or "
        "'epoch', "
        "the instant of UTC at which it is");
  if (talker_.size() != 2 || !std::all_of(talker_.begin(), talker_.end(), [](char c) { return c >= 'A' && c <= 'Z'; }))
    throw ComponentError("'" + talker_ + "' is no talker: two capital letters are, like GP, GN or IN", "/talker");
  const auto quality =
      std::find_if(qualities.begin(), qualities.end(), [&](const auto& q) { return q.name == p.text("quality"); });
  quality_ = quality->gga;
  mode_ = quality->mode;
  geoid_separation_ = p.has("geoid_separation") ? p.number("geoid_separation") : nan;
  max_sigma_ = p.has("max_sigma") ? p.number("max_sigma") : std::numeric_limits<double>::infinity();
  choose_sentences(binding);
  if (p.has("max_sigma")) find_sigma(binding);
  const bool has_gga = std::find(types_.begin(), types_.end(), Type::gga) != types_.end();
  if (has_gga && position_[2].is_bound() && std::isnan(geoid_separation_))
    binding.note("GGA has no height: it is one above the sea, and there is no 'geoid_separation'");
  text_.reserve(types_.size() * 128);
}

void NmeaWriter::choose_sentences(const Binding& binding) {
  const bool has_position = position_[0].is_bound() && position_[1].is_bound();
  const bool has_velocity = velocity_[0].is_bound() && velocity_[1].is_bound();
  const std::array<bool, 4> is_possible{has_position, has_position, has_velocity, yaw_.is_bound()};
  const std::array<const char*, 4> needs{"'lat' and 'lon'", "'lat' and 'lon'", "'vn' and 've'", "'yaw'"};
  if (!binding.parameters().has("sentences")) {
    for (std::size_t i = 0; i < type_names.size(); ++i)
      if (is_possible[i]) types_.push_back(static_cast<Type>(i));
    if (types_.empty())
      throw ComponentError(
          "the channel has no field for a sentence; a filter's are mapped: \"fields\": {\"lat\": \"position.lat\", …}");
    return;
  }
  for (const auto& element : binding.parameters().list("sentences")) {
    const auto i =
        static_cast<std::size_t>(std::find(type_names.begin(), type_names.end(), element.text) - type_names.begin());
    if (!is_possible[i])
      throw ComponentError(element.text + " needs " + needs[i] +
                               "; a filter's fields are mapped: \"fields\": {\"lat\": \"position.lat\", …}",
                           "/sentences");
    types_.push_back(static_cast<Type>(i));
  }
}

/// The components north and east [m], "position.north" of a filter's channel.
void NmeaWriter::find_sigma(const Binding& binding) {
  const auto& components = binding.covariance(binding.input("input"));
  covariance_dof_ = components.size();
  constexpr std::array<std::string_view, 2> wanted{"north", "east"};
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto is_wanted = [&](const NamedUnit& component) {
      return component.unit == "m" &&
             (component.name == wanted[axis] || component.name.ends_with("." + std::string(wanted[axis])));
    };
    const auto count = std::count_if(components.begin(), components.end(), is_wanted);
    if (count != 1)
      throw ComponentError("the channel's covariance has " + std::string(count == 0 ? "no" : "more than one") +
                               " component '" + std::string(wanted[axis]) + "' in m",
                           "/max_sigma");
    sigma_[axis] =
        static_cast<std::size_t>(std::find_if(components.begin(), components.end(), is_wanted) - components.begin());
  }
}

double NmeaWriter::horizontal_sigma(const SampleView& sample) const {
  if (covariance_dof_ == 0) return 0;
  if (!sample.covariance) return std::numeric_limits<double>::infinity();
  const auto variance = [&](std::size_t i) { return sample.covariance[i * (covariance_dof_ + 1)]; };
  return std::sqrt(variance(sigma_[0]) + variance(sigma_[1]));
}

void NmeaWriter::on(Input /*from*/, const SampleView& sample) {
  constexpr Time half_a_millisecond = 500'000;
  Fix fix{};
  fix.utc = clock_.utc(sample.t + half_a_millisecond);
  fix.lat = sample[position_[0]];
  fix.lon = std::remainder(sample[position_[1]], 2 * std::numbers::pi);
  fix.height = sample[position_[2]];
  fix.is_valid = std::isfinite(fix.lat) && std::isfinite(fix.lon) && horizontal_sigma(sample) <= max_sigma_;
  const double vn = sample[velocity_[0]], ve = sample[velocity_[1]];
  fix.speed = std::hypot(vn, ve);
  fix.course = fix.speed > 0 ? std::atan2(ve, vn) : nan;
  fix.yaw = sample[yaw_];
  for (const Type type : types_) {
    text_.clear();
    append(type, fix);
    output_.write(text_);
  }
}

void NmeaWriter::append(Type type, const Fix& fix) {
  SentenceWriter out(text_, talker_, type_names[static_cast<std::size_t>(type)]);
  const auto position = [&] {
    out.latitude(fix.is_valid ? fix.lat : nan);
    out.longitude(fix.is_valid ? fix.lon : nan);
  };
  const auto separation = [&](double value) {
    out.number(fix.is_valid && std::isfinite(fix.height) ? value : nan, 3);
    out.letter('M');
  };
  switch (type) {
    case Type::gga:
      out.time_of_day(fix.utc.of_day);
      position();
      out.letter(fix.is_valid ? quality_ : '0');
      out.empty();  // satellites in use
      out.empty();  // HDOP
      separation(fix.height - geoid_separation_);
      separation(geoid_separation_);
      out.empty();  // age of corrections
      out.empty();  // their station
      break;
    case Type::rmc:
      out.time_of_day(fix.utc.of_day);
      out.letter(fix.is_valid ? 'A' : 'V');
      position();
      out.number(fix.speed / knot, 3);
      out.bearing(fix.course, 3);
      out.date(fix.utc.day);
      out.empty();  // magnetic variation
      out.empty();
      out.letter(fix.is_valid ? mode_ : 'N');
      break;
    case Type::vtg:
      out.bearing(fix.course, 3);
      out.letter('T');
      out.empty();  // magnetic course
      out.letter('M');
      out.number(fix.speed / knot, 3);
      out.letter('N');
      out.number(fix.speed * 3.6, 3);
      out.letter('K');
      out.letter(std::isfinite(fix.speed) ? mode_ : 'N');
      break;
    case Type::hdt:
      out.bearing(fix.yaw, 3);
      out.letter('T');
      break;
  }
  out.end();
}

}  // namespace binnacle::nmea
