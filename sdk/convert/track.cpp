// SPDX-License-Identifier: Apache-2.0
#include "convert/track.hpp"

#include <array>
#include <cmath>
#include <initializer_list>
#include <string_view>

#include "binnacle/geodesy.hpp"
#include "binnacle/unit.hpp"
#include "local_frame.hpp"

namespace binnacle::convert {

namespace {

using results::Estimate;
using results::FilterResults;

const Estimate* output(const FilterResults& filter, const std::string& block, std::string_view name,
                       std::string_view unit) {
  for (const auto& estimate : filter.estimates)
    if ((block.empty() || estimate.block == block) && estimate.output == name && estimate.unit == unit)
      return &estimate;
  return nullptr;
}

double at(const std::vector<double>& values, std::size_t i) { return i < values.size() ? values[i] : Record::unknown; }

/// The block's outputs that are a position, and how.
struct Position {
  PositionKind kind;
  std::array<const Estimate*, 3> outputs;  // the third may be missing
  bool is_third_height = false;            // of local axes: up, not down
};

std::optional<Position> position_in(const FilterResults& filter, const std::string& block) {
  const auto all = [&](std::initializer_list<const char*> names, std::initializer_list<const char*> units) {
    Position position{PositionKind::geodetic, {}, false};
    for (std::size_t i = 0; i < 3; ++i) position.outputs[i] = output(filter, block, names.begin()[i], units.begin()[i]);
    return position;
  };
  Position found = all({"lat", "lon", "height"}, {"rad", "rad", "m"});
  if (found.outputs[0] && found.outputs[1]) return found;
  found = all({"x", "y", "z"}, {"m", "m", "m"});
  found.kind = PositionKind::ecef;
  if (found.outputs[0] && found.outputs[0]->kind == "position.ecef" && found.outputs[1] && found.outputs[2])
    return found;
  found = all({"north", "east", "down"}, {"m", "m", "m"});
  found.kind = PositionKind::local;
  if (!found.outputs[2]) found.outputs[2] = output(filter, block, "height", "m"), found.is_third_height = true;
  if (found.outputs[0] && found.outputs[1]) return found;
  return {};
}

/// vn, ve, vd of one block; vx, vy, vz of one of kind velocity.ecef.
struct Velocity {
  std::array<const Estimate*, 3> outputs{};
  bool is_ecef = false;
};

Velocity velocity_of(const FilterResults& filter) {
  Velocity velocity;
  if (const auto* north = output(filter, "", "vn", "m/s")) {
    velocity.outputs = {north, output(filter, north->block, "ve", "m/s"), output(filter, north->block, "vd", "m/s")};
  } else if (const auto* x = output(filter, "", "vx", "m/s"); x && x->kind == "velocity.ecef") {
    velocity.outputs = {x, output(filter, x->block, "vy", "m/s"), output(filter, x->block, "vz", "m/s")};
    velocity.is_ecef = true;
  }
  return velocity;
}

void put_position(const Position& position, const LocalFrame* frame, Record& record) {
  std::array<double, 3> value{}, sigma{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto* output = position.outputs[i];
    value[i] = output ? at(output->values, record.index) : 0;
    sigma[i] = output ? at(output->sigma, record.index) : Record::unknown;
  }
  Eigen::Vector3d lla(value[0], value[1], value[2]), ecef = lla;
  if (position.kind == PositionKind::geodetic) {
    const geodesy::Radii r = geodesy::radii(lla[0]);
    sigma[0] *= r.meridian + lla[2];
    sigma[1] *= (r.transverse + lla[2]) * std::cos(lla[0]);
    ecef = geodesy::ecef_from_lla(lla);
    if (!position.outputs[2]) lla[2] = Record::unknown;
  } else {
    if (position.kind == PositionKind::local)
      ecef = frame->ecef({value[0], value[1], position.is_third_height ? -value[2] : value[2]});
    lla = geodesy::lla_from_ecef(ecef);
  }
  record.lat = lla[0];
  record.lon = geodesy::wrapped_longitude(lla[1]);
  record.height = lla[2];
  for (std::size_t i = 0; i < 3; ++i) {
    record.ecef[i] = ecef[static_cast<Eigen::Index>(i)];
    record.sigma[i] = sigma[i];
  }
}

void put_velocity(const Velocity& velocity, Record& record) {
  Eigen::Vector3d v = Eigen::Vector3d::Constant(Record::unknown);
  for (std::size_t i = 0; i < 3; ++i) {
    if (!velocity.outputs[i]) continue;
    v[static_cast<Eigen::Index>(i)] = at(velocity.outputs[i]->values, record.index);
    record.velocity_sigma[i] = at(velocity.outputs[i]->sigma, record.index);
  }
  if (velocity.is_ecef) v = geodesy::C_en(record.lat, record.lon).transpose() * v;
  for (std::size_t i = 0; i < 3; ++i) record.velocity[i] = v[static_cast<Eigen::Index>(i)];
}

[[noreturn]] void refuse_local(const std::string& filter, const std::string& block) {
  throw Refusal("the position '" + block + "' of filter '" + filter +
                "' is local, north and east in metres, without an origin: give --origin LAT,LON,HEIGHT, or \"origin\" "
                "in the config");
}

std::pair<std::string, Position> position_of(const FilterResults& filter) {
  for (const auto& estimate : filter.estimates)
    if (const auto found = position_in(filter, estimate.block)) return {estimate.block, *found};
  std::string blocks;
  for (const auto& estimate : filter.estimates)
    if (blocks.find("'" + estimate.block + "'") == std::string::npos)
      blocks += (blocks.empty() ? "'" : ", '") + estimate.block + "'";
  throw NoData("filter '" + filter.name + "' estimates no position: none of its blocks (" + blocks +
               ") has lat and lon, or north and east in metres, or is of kind position.ecef");
}

}  // namespace

double Record::horizontal_sigma() const { return std::hypot(sigma[0], sigma[1]); }

Track track_of(const FilterResults& filter, const std::vector<std::size_t>& indices,
               const std::optional<Place>& origin) {
  const auto [block, position] = position_of(filter);
  if (position.kind == PositionKind::local && !origin) refuse_local(filter.name, block);
  std::optional<LocalFrame> frame;
  if (position.kind == PositionKind::local) frame.emplace(*origin);
  const Velocity velocity = velocity_of(filter);
  const Estimate* const yaw = output(filter, "", "yaw", "rad");
  Track track{filter.name,
              block,
              position.kind,
              velocity.outputs[0] && velocity.outputs[1],
              velocity.is_ecef,
              yaw != nullptr,
              position.kind == PositionKind::ecef || position.outputs[2],
              {},
              0};
  const std::vector<Time> t = times_of(filter);
  for (const std::size_t i : indices) {
    Record record;
    record.t = t[i];
    record.index = i;
    put_position(position, frame ? &*frame : nullptr, record);
    put_velocity(velocity, record);
    if (yaw) record.yaw = at(yaw->values, i);
    const bool is_position =
        std::isfinite(record.lat) && std::isfinite(record.lon) && (!track.has_vertical || std::isfinite(record.height));
    if (is_position)
      track.records.push_back(record);
    else
      ++track.left_out;
  }
  return track;
}

std::vector<Time> times_of(const FilterResults& filter) {
  std::vector<Time> t;
  t.reserve(filter.t.size());
  for (const double s : filter.t) {
    if (!(std::abs(s) < 9.2e9))
      throw NoData("filter '" + filter.name + "' has a time that is none: the results are damaged");
    t.push_back(from_seconds(s));
  }
  return t;
}

std::vector<std::size_t> chosen(const std::vector<Time>& t, std::size_t every, double rate) {
  std::vector<std::size_t> indices;
  const double period = rate > 0 ? 1e9 / rate : 0;
  constexpr double near = 1000;  // ns: of times since 1980 a double knows a quarter of that
  double next = 0;               // multiple of the period
  for (std::size_t i = 0; i < t.size(); i += every) {
    const auto since = static_cast<double>(t[i] - t[0]);
    if (rate > 0 && since < next * period - near) continue;
    indices.push_back(i);
    if (rate > 0) next = std::floor((since + near) / period) + 1;
  }
  return indices;
}

}  // namespace binnacle::convert
