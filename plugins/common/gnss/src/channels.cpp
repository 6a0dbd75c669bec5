// SPDX-License-Identifier: Apache-2.0
// The channels that carry GNSS data: their fields, and rows to and from messages.
#include "gnss/channels.hpp"

#include <string>

namespace binnacle::gnss {

namespace {

struct Member {
  const char* name;
  const char* unit;
  double Ephemeris::*value;
  const char* text;
};

constexpr Member members[] = {
    {"toe", "s", &Ephemeris::toe, "reference time of the orbit, on the channel's clock"},
    {"toc", "s", &Ephemeris::toc, "reference time of the clock, on the channel's clock"},
    {"semi_major_axis", "m", &Ephemeris::semi_major_axis, "semi-major axis"},
    {"eccentricity", "1", &Ephemeris::eccentricity, "eccentricity"},
    {"i0", "rad", &Ephemeris::i0, "inclination at toe"},
    {"omega0", "rad", &Ephemeris::omega0, "longitude of the ascending node at the start of the week"},
    {"perigee", "rad", &Ephemeris::perigee, "argument of perigee"},
    {"m0", "rad", &Ephemeris::m0, "mean anomaly at toe"},
    {"delta_n", "rad/s", &Ephemeris::delta_n, "correction of the mean motion"},
    {"omega_dot", "rad/s", &Ephemeris::omega_dot, "rate of right ascension"},
    {"i_dot", "rad/s", &Ephemeris::i_dot, "rate of inclination"},
    {"cuc", "rad", &Ephemeris::cuc, "cosine term of the argument of latitude"},
    {"cus", "rad", &Ephemeris::cus, "sine term of the argument of latitude"},
    {"crc", "m", &Ephemeris::crc, "cosine term of the radius"},
    {"crs", "m", &Ephemeris::crs, "sine term of the radius"},
    {"cic", "rad", &Ephemeris::cic, "cosine term of the inclination"},
    {"cis", "rad", &Ephemeris::cis, "sine term of the inclination"},
    {"af0", "s", &Ephemeris::af0, "clock offset"},
    {"af1", "1", &Ephemeris::af1, "clock drift, s/s"},
    {"af2", "1/s", &Ephemeris::af2, "clock ageing, s/s^2"},
    {"group_delay", "s", &Ephemeris::group_delay, "group delay: T_GD, BGD, TGD1"},
    {"accuracy", "m", &Ephemeris::accuracy, "accuracy: URA, SISA"},
    {"issue", "1", &Ephemeris::issue, "issue of data: IODE, IODnav"},
};
static_assert(std::size(members) + 1 == ephemeris_field_count);

FieldSpec row_field(const char* name, const char* unit, bool optional, std::string text) {
  return {name, unit, FieldKind::level, optional, true, std::move(text)};
}

FieldSpec satellite_field() {
  return row_field("satellite", "1", false,
                   "constellation (1 GPS, 2 Galileo, 3 BeiDou) times 100, plus the satellite's number");
}

}  // namespace

std::vector<FieldSpec> observation_fields(bool rate_is_optional) {
  return {satellite_field(), row_field("pseudorange", "m", false, "measured pseudorange"),
          row_field("range_rate", "m/s", rate_is_optional, "measured range rate, positive if the range grows"),
          row_field("cn0", "1", true, "carrier to noise density, dB-Hz")};
}

std::vector<FieldSpec> ephemeris_fields() {
  std::vector<FieldSpec> fields{satellite_field()};
  for (const Member& member : members) fields.push_back(row_field(member.name, member.unit, false, member.text));
  return fields;
}

std::vector<FieldSpec> klobuchar_fields() {
  std::vector<FieldSpec> fields;
  for (const char letter : {'a', 'b'})
    for (int n = 0; n < 4; ++n)
      fields.push_back({std::string(1, letter).append(std::to_string(n)), "s", FieldKind::level, false, false,
                        std::string(letter == 'a' ? "alpha_" : "beta_") + std::to_string(n) + ", s/semicircle^" +
                            std::to_string(n)});
  return fields;
}

void write_ephemeris(const Ephemeris& ephemeris, double* row) {
  *row++ = static_cast<double>(ephemeris.satellite);
  for (const Member& member : members) *row++ = ephemeris.*member.value;
}

Ephemeris read_ephemeris(const double* row) {
  Ephemeris ephemeris;
  ephemeris.satellite = satellite_key(*row++);
  for (const Member& member : members) ephemeris.*member.value = *row++;
  return ephemeris;
}

Klobuchar read_klobuchar(const double* fields) {
  Klobuchar model;
  for (int n = 0; n < 4; ++n) {
    model.alpha[n] = fields[n];
    model.beta[n] = fields[4 + n];
  }
  return model;
}

const double* find_ephemeris(const SampleView& ephemerides, SatelliteKey satellite) {
  if (!ephemerides.available) return nullptr;
  for (int i = 0; i < ephemerides.rows; ++i) {
    const double* row = ephemerides.row_fields + i * ephemeris_field_count;
    if (satellite_key(row[0]) == satellite) return row;
  }
  return nullptr;
}

ChannelPort ephemeris_port() { return {"ephemeris", ephemeris_fields(), false, "current broadcast orbits and clocks"}; }

ChannelPort klobuchar_port() {
  return {"iono", klobuchar_fields(), true, "broadcast ionosphere coefficients, for \"ionosphere\": \"klobuchar\""};
}

}  // namespace binnacle::gnss
