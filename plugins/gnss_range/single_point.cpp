// SPDX-License-Identifier: Apache-2.0
// Single-point solutions: position, velocity and clock of each epoch by itself, by iterated least squares.
#include "single_point.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <span>

#include "algebra/decompositions.hpp"
#include "binnacle/view.hpp"
#include "strapdown/earth.hpp"

namespace binnacle::gnss_range {

using Eigen::Vector3d;

namespace {

constexpr int offsets = 2;             // what Galileo, BeiDou have more than the first system there is
constexpr int unknowns = 4 + offsets;  // x y z, clock
using Normal = Eigen::Matrix<double, unknowns, unknowns>;
using Unknowns = Eigen::Matrix<double, unknowns, 1>;
using Covariance = Eigen::Matrix<double, 8, 8>;
constexpr int most_iterations = 20;
constexpr double converged = 1e-4;               // m
constexpr double rough = 1e3;                    // m: a place this good has elevations
constexpr double lowest = 6.0e6, highest = 1e8;  // m from the earth's centre

double squared(double x) { return x * x; }

/// The systems of an epoch. The clock is that of the first; −1 is the offset of a satellite on it.
struct Systems {
  std::array<bool, 1 + gnss::constellations().size()> is_there{};
  int count = 0;
  gnss::Constellation first = gnss::Constellation::none;

  Systems(std::span<const gnss::Sighting> sightings) {
    for (const gnss::Sighting& s : sightings) {
      const auto constellation = gnss::constellation_of(s.satellite);
      bool& known = is_there[static_cast<std::size_t>(constellation)];
      count += !known;
      known = true;
      if (first == gnss::Constellation::none || constellation < first) first = constellation;
    }
  }
  int offset_of(const gnss::Sighting& s) const {
    const auto constellation = gnss::constellation_of(s.satellite);
    return constellation == first ? -1
                                  : static_cast<int>(constellation) - static_cast<int>(gnss::Constellation::galileo);
  }
  bool has_offset(int i) const {
    const auto constellation = static_cast<gnss::Constellation>(static_cast<int>(gnss::Constellation::galileo) + i);
    return constellation != first && is_there[static_cast<std::size_t>(constellation)];
  }
};

Unknowns design(const gnss::Sighting& s, int offset) {
  Unknowns a = Unknowns::Zero();
  a.head<4>() << -s.path.scale * s.path.direction, 1;
  if (offset >= 0) a[4 + offset] = 1;
  return a;
}

}  // namespace

/// The latest messages and the latest place: where the next epoch begins.
struct SinglePointState {
  std::int64_t ephemeris_rows = 0;
  double ephemerides[gnss::most_messages * gnss::ephemeris_field_count] = {};
  std::int64_t has_klobuchar = 0;
  double klobuchar[8] = {};
  std::int64_t has_place = 0;
  double place[3] = {};
};

struct SinglePointFix {
  gnss::AntennaPlace place{Vector3d::Zero(), Vector3d::Zero(), Eigen::Matrix3d::Identity()};
  bool knows_place = false;
  double clock = 0;                      // m
  std::array<double, offsets> offset{};  // m
  Vector3d velocity = Vector3d::Zero();
  double drift = 0;  // m/s
  Normal cofactors = Normal::Zero();
  Covariance P = Covariance::Zero();  // x y z, vx vy vz, bias, drift
  double gdop = 0;
  int used = 0;
  int excluded_count = 0;
  std::array<gnss::SatelliteKey, gnss::most_rows> excluded{};
};

namespace {

/// Of an epoch: N x = b, and N without weights, for the dilution of precision.
struct NormalEquations {
  Normal N = Normal::Zero(), plain = Normal::Zero();
  Unknowns b = Unknowns::Zero();
};

/// For the first unknowns; the others, which the epoch does not have, stay. False: not determined.
bool solve_first(int size, const NormalEquations& e, Unknowns& dx, SinglePointFix& fix) {
  const algebra::SmallPivotedCholesky solver(e.N.topLeftCorner(size, size)),
      unweighted(e.plain.topLeftCorner(size, size));
  if (!solver.is_factored() || !(unweighted.D().minCoeff() > 1e-9)) return false;
  const algebra::SmallPivotedCholesky::Vector solution = solver.solve_vector(e.b.head(size));
  if (!solution.allFinite()) return false;
  dx.head(size) = solution;
  const algebra::SmallMatrix identity = algebra::SmallMatrix::Identity(size, size);
  fix.cofactors.setZero();
  fix.cofactors.topLeftCorner(size, size) = solver.solve(identity);
  fix.gdop = std::sqrt(unweighted.solve(identity).diagonal().head<4>().sum());
  return true;
}

double residual_of(const gnss::Sighting& s, int offset, const SinglePointFix& fix) {
  const double system = offset >= 0 ? fix.offset[static_cast<std::size_t>(offset)] : 0;
  return s.pseudorange - (s.path.range + fix.clock + system + s.delay);
}

}  // namespace

ComponentSpec SinglePoint::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "single_point";
  spec.summary = "Position, velocity and clock of each single epoch, by iterated least squares.";
  spec.source =
      "Misra and Enge, Global Positioning System: Signals, Measurements, and Performance, 2nd ed., chapter 6; "
      "exclusion by the largest normalized residual: Baarda, A testing procedure for use in geodetic networks, 1968";
  spec.inputs = {gnss::ephemeris_port(),
                 gnss::klobuchar_port(),
                 {"obs", gnss::observation_fields(true), false, "pseudoranges and, if available, range rates"}};
  spec.parameters = {object("pseudorange", gnss::RangeNoise::parameters(gnss::RangeNoise::Of::pseudorange, "\"5 m\""))
                         .defaults("{}")
                         .about("noise of pseudoranges"),
                     object("range_rate", gnss::RangeNoise::parameters(gnss::RangeNoise::Of::range_rate, "\"0.1 m/s\""))
                         .defaults("{}")
                         .about("noise of range rates")};
  for (auto& parameter : gnss::Corrections::parameters()) spec.parameters.push_back(std::move(parameter));
  for (auto& parameter : SatelliteLimit::parameters()) spec.parameters.push_back(std::move(parameter));
  spec.parameters.push_back(number("exclude_beyond", "1")
                                .above(0)
                                .defaults("5")
                                .about("largest normalized residual; satellites beyond it are excluded, the largest "
                                       "first, while there are more satellites than unknowns"));
  spec.parameters.push_back(number("max_gdop", "1").above(0).defaults("30").about("largest GDOP of a solution"));
  spec.parameters.push_back(number("unknown_speed", "m/s")
                                .above(0)
                                .defaults("100")
                                .about("standard deviation of the velocity, which is zero without range rates"));
  spec.parameters.push_back(number("unknown_drift", "m/s")
                                .above(0)
                                .defaults("1000")
                                .about("standard deviation of the clock's drift, which is zero without range rates"));
  spec.example = R"json({"inputs": {"obs": "gnss.obs", "ephemeris": "gnss.ephemeris", "iono": "gnss.iono"},
    "ionosphere": "klobuchar", "troposphere": "saastamoinen"})json";
  return spec;
}

SinglePoint::SinglePoint(const Binding& binding)
    : corrections_(binding),
      limit_(binding.parameters()),
      range_noise_(binding.parameters().object("pseudorange"), gnss::RangeNoise::Of::pseudorange),
      rate_noise_(binding.parameters().object("range_rate"), gnss::RangeNoise::Of::range_rate),
      exclude_beyond_(binding.parameters().number("exclude_beyond")),
      max_gdop_(binding.parameters().number("max_gdop")),
      unknown_speed_(binding.parameters().number("unknown_speed")),
      unknown_drift_(binding.parameters().number("unknown_drift")) {
  ephemeris_ = binding.input("ephemeris");
  klobuchar_ = binding.input("iono");
  ecef_ = declare("", false);
  ned_ = declare("ned", true);
  state_ = declaration_.keeps<SinglePointState>();
}

SinglePoint::Solution SinglePoint::declare(const char* name, bool is_geodetic) {
  Solution handles;
  ChannelDeclaration channel(name);
  static_cast<PlaceFields&>(handles) = is_geodetic ? carry_geodetic(channel) : carry_ecef(channel);
  handles.clock = channel.carries(level("bias", "m", "how far the receiver's clock is ahead, times c"),
                                  level("drift", "m/s", "its rate, times c"));
  handles.count =
      channel.carries(level("satellites", "1", "used"), level("excluded", "1", "left out for their residual"));
  handles.gdop = channel.carries(level("gdop", "1", "geometric dilution of precision"));
  const auto deviations = [&](const char* x, const char* y, const char* z, const char* unit) {
    const char* const text = "standard deviation";
    return channel.carries(level(x, unit, text), level(y, unit, text), level(z, unit, text));
  };
  if (is_geodetic) {
    handles.position_sd = deviations("position_sd_n", "position_sd_e", "position_sd_d", "m");
    handles.velocity_sd = deviations("velocity_sd_n", "velocity_sd_e", "velocity_sd_d", "m/s");
  }
  const std::array<const char*, 3> axes = is_geodetic ? std::array{"north", "east", "down"} : std::array{"x", "y", "z"};
  for (const char* axis : axes) channel.covariance.push_back({std::string("position.") + axis, "m"});
  for (const char* axis : axes) channel.covariance.push_back({std::string("velocity.") + axis, "m/s"});
  channel.covariance.push_back({"receiver_clock.bias", "m"});
  channel.covariance.push_back({"receiver_clock.drift", "m/s"});
  handles.channel = declaration_.emits(std::move(channel));
  return handles;
}

void SinglePoint::on(const TransformInput& in, Emitter& emitter) const {
  const SampleView& sample = in.sample;
  SinglePointState& state = in.memory[state_];
  if (in.from == ephemeris_) {
    const int rows = std::clamp(sample.rows, 0, gnss::most_messages);
    state.ephemeris_rows = rows;
    std::copy_n(sample.row_fields, rows * gnss::ephemeris_field_count, state.ephemerides);
    return;
  }
  if (in.from == klobuchar_) {
    state.has_klobuchar = 1;
    std::copy_n(sample.fields, 8, state.klobuchar);
    return;
  }
  if (corrections_.wants_klobuchar() && state.has_klobuchar != 1) return;
  SampleView ephemerides;
  ephemerides.rows = static_cast<int>(std::clamp<std::int64_t>(state.ephemeris_rows, 0, gnss::most_messages));
  ephemerides.row_fields = state.ephemerides;
  ephemerides.available = true;
  SampleView klobuchar;
  klobuchar.fields = state.klobuchar;
  const gnss::Corrections::Epoch epoch{sample.t, &sample, &ephemerides, &klobuchar};

  SinglePointFix fix;
  const Vector3d last = vector_at<3>(state.place);
  if (state.has_place == 1 && last.norm() > lowest && last.norm() < highest) {
    fix.place = gnss::place_from_ecef(last);
    fix.knows_place = true;
  }
  if (!solve(epoch, fix)) return;
  vector_at<3>(state.place) = fix.place.ecef;
  state.has_place = 1;
  emit(sample.t, fix, emitter);
}

/// From the last place, or from the earth's centre; until the place is known to `rough`, without elevations.
bool SinglePoint::solve(const gnss::Corrections::Epoch& epoch, SinglePointFix& fix) const {
  Sightings sightings;
  int count = 0;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const bool knows_place = fix.knows_place;
    count = sight(epoch, knows_place, fix, sightings);
    double moved = 0;
    if (!step(sightings, count, knows_place, fix, moved)) return false;
    const double radius = fix.place.ecef.norm();
    const bool is_on_earth = radius > lowest && radius < highest;
    if (!is_on_earth && iteration > 8) return false;
    fix.knows_place = is_on_earth && (knows_place || moved < rough);
    if (is_on_earth) {
      fix.place = gnss::place_from_ecef(fix.place.ecef);
    }
    if (!knows_place || moved > converged) continue;
    const Verdict verdict = exclude_worst(sightings, count, fix);
    if (verdict == Verdict::excluded) continue;
    if (verdict == Verdict::disagree) return false;
    if (!(fix.gdop <= max_gdop_)) return false;
    fix.used = count;
    solve_velocity(sightings, count, fix);
    return true;
  }
  return false;
}

int SinglePoint::sight(const gnss::Corrections::Epoch& epoch, bool knows_place, const SinglePointFix& fix,
                       Sightings& sightings) const {
  int count = corrections_.sight(epoch, fix.place, knows_place, sightings).used;
  const auto end = fix.excluded.begin() + fix.excluded_count;
  const auto kept = std::remove_if(sightings.begin(), sightings.begin() + count, [&](const gnss::Sighting& s) {
    if (knows_place && !(range_noise_.variance(s) > 0)) return true;  // no C/N0 where the noise needs one
    return std::find(fix.excluded.begin(), end, s.satellite) != end;
  });
  count = static_cast<int>(kept - sightings.begin());
  return knows_place ? gnss::Corrections::keep_highest(sightings, count, limit_.at(epoch.t)) : count;
}

bool SinglePoint::step(const Sightings& sightings, int count, bool knows_place, SinglePointFix& fix,
                       double& moved) const {
  NormalEquations e;
  const std::span epoch(sightings.data(), static_cast<std::size_t>(count));
  const Systems systems(epoch);
  for (const gnss::Sighting& s : epoch) {
    const int offset = systems.offset_of(s);
    const Unknowns a = design(s, offset);
    const double residual = residual_of(s, offset, fix);
    const double weight = knows_place ? 1 / range_noise_.variance(s) : 1;
    e.N += weight * a * a.transpose();
    e.plain += a * a.transpose();
    e.b += weight * residual * a;
  }
  if (count < 3 + systems.count) return false;
  for (int i = 0; i < offsets; ++i)
    if (!systems.has_offset(i)) e.N(4 + i, 4 + i) = e.plain(4 + i, 4 + i) = 1;
  Unknowns dx = Unknowns::Zero();
  if (!(solve_first(systems.has_offset(offsets - 1) ? unknowns : unknowns - 1, e, dx, fix))) return false;
  fix.place.ecef += dx.head<3>();
  fix.clock += dx[3];
  for (int i = 0; i < offsets; ++i) fix.offset[static_cast<std::size_t>(i)] += dx[4 + i];
  moved = dx.head<3>().norm();
  return true;
}

/// Baarda's data snooping: r_i over the standard deviation that the fit leaves it, σ_i² − a_i N⁻¹ a_iᵀ.
SinglePoint::Verdict SinglePoint::exclude_worst(const Sightings& sightings, int count, SinglePointFix& fix) const {
  const Systems systems(std::span(sightings.data(), static_cast<std::size_t>(count)));
  const int to_spare = count - 3 - systems.count;
  double worst = exclude_beyond_;
  int at = -1;
  for (int i = 0; i < count; ++i) {
    const gnss::Sighting& s = sightings[static_cast<std::size_t>(i)];
    const int offset = systems.offset_of(s);
    const Unknowns a = design(s, offset);
    const double residual = residual_of(s, offset, fix);
    const double variance = range_noise_.variance(s);
    const double left = variance - a.dot(fix.cofactors * a);
    if (!(left > 1e-6 * variance)) continue;
    const double normalized = std::abs(residual) / std::sqrt(left);
    if (normalized > worst) {
      worst = normalized;
      at = i;
    }
  }
  if (at < 0) return Verdict::agree;
  if (to_spare < 2) return Verdict::disagree;  // with one to spare nobody knows which it is
  fix.excluded[static_cast<std::size_t>(fix.excluded_count++)] = sightings[static_cast<std::size_t>(at)].satellite;
  return Verdict::excluded;
}

void SinglePoint::solve_velocity(const Sightings& sightings, int count, SinglePointFix& fix) const {
  fix.P.setZero();
  // Order of P: position, velocity, bias, drift; of the fit: position, bias.
  constexpr int of_fit[] = {0, 1, 2, 6}, of_rates[] = {3, 4, 5, 7};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) fix.P(of_fit[i], of_fit[j]) = fix.cofactors(i, j);
  Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  int rates = 0;
  for (int i = 0; i < count; ++i) {
    const gnss::Sighting& s = sightings[static_cast<std::size_t>(i)];
    if (!(std::abs(s.range_rate) < 1e6) || !(rate_noise_.variance(s) > 0)) continue;
    const gnss::RangeRate at_rest = gnss::range_rate(s.path, s.velocity, Vector3d::Zero(), corrections_.has_rotation());
    Eigen::Vector4d a;
    a << at_rest.by_velocity.transpose(), 1;
    const double weight = 1 / rate_noise_.variance(s);
    N += weight * a * a.transpose();
    b += weight * (s.range_rate - at_rest.rate - s.rate_delay) * a;
    ++rates;
  }
  const algebra::SmallPivotedCholesky solver(N);
  const bool is_solved = rates >= 4 && solver.is_factored() && solver.D().minCoeff() > 0;
  const Eigen::Vector4d solution = is_solved ? Eigen::Vector4d(solver.solve_vector(b)) : Eigen::Vector4d::Zero();
  Eigen::Matrix4d cofactors = Eigen::Matrix4d::Zero();
  if (is_solved && solution.allFinite()) {
    fix.velocity = solution.head<3>();
    fix.drift = solution[3];
    cofactors = solver.solve(Eigen::Matrix4d::Identity());
  } else {
    fix.velocity.setZero();
    fix.drift = 0;
    cofactors.diagonal() << Vector3d::Constant(squared(unknown_speed_)), squared(unknown_drift_);
  }
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) fix.P(of_rates[i], of_rates[j]) = cofactors(i, j);
}

void SinglePoint::write(Time t, const SinglePointFix& fix, const Solution& to, SampleWriter& out) const {
  out.t = t;
  out[to.clock] = Eigen::Vector2d(fix.clock, fix.drift);
  out[to.count] = Eigen::Vector2d(fix.used, fix.excluded_count);
  out[to.gdop] = fix.gdop;
}

void SinglePoint::emit(Time t, const SinglePointFix& fix, Emitter& emitter) const {
  SampleWriter& ecef = emitter.on(ecef_.channel);
  write(t, fix, ecef_, ecef);
  ecef[ecef_.position] = fix.place.ecef;
  ecef[ecef_.velocity] = fix.velocity;
  ecef.attach_covariance().as<8, 8>() = fix.P;
  emitter.emit(ecef_.channel);

  const Eigen::Matrix3d C_ne = fix.place.C_en.transpose();
  Covariance turn = Covariance::Identity();
  turn.topLeftCorner<3, 3>() = C_ne;
  turn.block<3, 3>(3, 3) = C_ne;
  const Covariance P = turn * fix.P * turn.transpose();
  SampleWriter& ned = emitter.on(ned_.channel);
  write(t, fix, ned_, ned);
  ned[ned_.position] = fix.place.lla;
  ned[ned_.velocity] = C_ne * fix.velocity;
  for (int i = 0; i < 3; ++i) ned[ned_.position_sd[i]] = std::sqrt(P(i, i));
  for (int i = 0; i < 3; ++i) ned[ned_.velocity_sd[i]] = std::sqrt(P(3 + i, 3 + i));
  ned.attach_covariance().as<8, 8>() = 0.5 * (P + P.transpose());
  emitter.emit(ned_.channel);
}

}  // namespace binnacle::gnss_range
