// SPDX-License-Identifier: Apache-2.0
// The nmea_writer sink: a position, velocity and heading as sentences of NMEA 0183.
#include "nmea_writer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace binnacle::nmea {

namespace {

using sentences::qualities;
using sentences::Quality;
using sentences::Type;
using sentences::type_names;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

std::vector<std::string> quality_names() {
  std::vector<std::string> names;
  for (const Quality& quality : qualities) names.emplace_back(quality.name);
  return names;
}

std::vector<ParameterSpec> parameters() {
  using namespace parameter;
  auto specs = text_output::TextOutput::parameters();
  specs.push_back(list("sentences", choice("sentence", {type_names.begin(), type_names.end()}))
                      .about("sentences of each sample, in this order; default: those of GGA, RMC, VTG, HDT for which "
                             "the channel has the fields"));
  specs.push_back(
      text("talker").defaults("\"GP\"").about("first two letters of each sentence, for example GP, GN, IN"));
  specs.push_back(choice("quality", quality_names())
                      .defaults("\"estimated\"")
                      .about("quality of a valid position in GGA (6 for estimated), RMC and VTG (E)"));
  specs.push_back(number("max_sigma", "m")
                      .above(0)
                      .about("largest horizontal 1-sigma, sqrt(north^2 + east^2) of the channel's covariance, of a "
                             "valid position; default: every finite position is valid"));
  specs.push_back(number("geoid_separation", "m")
                      .about("height of the geoid above the ellipsoid, for heights above sea level in GGA; without it "
                             "GGA has no height"));
  for (ParameterSpec& spec : civil_time::UtcClock::parameters()) specs.push_back(std::move(spec));
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
  spec.inputs = {
      input("input", {level("lat", "rad").optional().about("geodetic latitude, WGS-84"),
                      level("lon", "rad").optional().about("longitude, east positive"),
                      level("height", "m").optional().about("height above the ellipsoid"),
                      level("vn", "m/s").optional().about("velocity over ground, north"),
                      level("ve", "m/s").optional().about("velocity over ground, east"),
                      level("yaw", "rad").optional().about("heading, clockwise from true north")})
          .about("channel to be written; for a filter's estimates use \"fields\": {\"lat\": \"position.lat\", …}")};
  spec.example = R"json({"input": "ins", "to": "tcp://:10110", "epoch": "2026-11-23T12:00:00Z",
    "geoid_separation": "47.5 m",
    "fields": {"lat": "position.lat", "lon": "position.lon", "height": "position.height",
               "vn": "velocity.vn", "ve": "velocity.ve", "yaw": "attitude.yaw"}})json";
  return spec;
}

NmeaWriter::NmeaWriter(const Binding& binding)
    : output_(binding.parameters()),
      clock_(binding.parameters()),
      position_(binding.fields(binding.input("input"), "lat", "lon", "height")),
      velocity_(binding.fields(binding.input("input"), "vn", "ve")),
      yaw_(binding.field(binding.input("input"), "yaw")) {
  const Parameters& p = binding.parameters();
  if (!p.has("week") && !p.has("epoch"))
    throw ComponentError(
        "sentences carry UTC: give 'week', the GPS week at whose start time is zero (0: seconds since 1980-01-06), or "
        "'epoch', the instant of UTC at which it is");
  read_report(p);
  max_sigma_ = p.has("max_sigma") ? p.number("max_sigma") : std::numeric_limits<double>::infinity();
  choose_sentences(binding);
  if (p.has("max_sigma")) find_sigma(binding);
  const bool has_gga = std::find(types_.begin(), types_.end(), Type::gga) != types_.end();
  if (has_gga && position_[2].is_bound() && !p.has("geoid_separation"))
    binding.note("GGA has no height: it needs the height above sea level, but 'geoid_separation' is missing");
  text_.reserve(types_.size() * 128);
}

void NmeaWriter::read_report(const Parameters& p) {
  const std::string& talker = p.text("talker");
  if (talker.size() != 2 || !std::all_of(talker.begin(), talker.end(), [](char c) { return c >= 'A' && c <= 'Z'; }))
    throw ComponentError("'" + talker + "' is not a talker: two capital letters are, like GP, GN or IN", "/talker");
  const auto quality =
      std::find_if(qualities.begin(), qualities.end(), [&](const auto& q) { return q.name == p.text("quality"); });
  report_.emplace(talker, *quality, p.has("geoid_separation") ? p.number("geoid_separation") : nan);
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
  sentences::Motion motion;
  motion.utc = clock_.utc(sentences::MotionReport::rounded(sample.t));
  motion.lat = sample[position_[0]];
  motion.lon = sample[position_[1]];
  motion.height = sample[position_[2]];
  motion.vn = sample[velocity_[0]];
  motion.ve = sample[velocity_[1]];
  motion.yaw = sample[yaw_];
  motion.is_accurate = horizontal_sigma(sample) <= max_sigma_;
  for (const Type type : types_) {
    text_.clear();
    report_->append(text_, type, motion);
    output_.write(text_);
  }
}

}  // namespace binnacle::nmea
