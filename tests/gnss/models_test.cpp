// SPDX-License-Identifier: Apache-2.0
// Plugin gnss_range: models against measurements made from first principles, Jacobians against differences.
#include <cmath>

#include "../../plugins/gnss_range/clock_block.hpp"
#include "../../plugins/gnss_range/clock_process.hpp"
#include "../../plugins/gnss_range/earth_blocks.hpp"
#include "../../plugins/gnss_range/ecef_pv.hpp"
#include "../../plugins/gnss_range/ned_antenna.hpp"
#include "../../plugins/gnss_range/pseudorange.hpp"
#include "../../plugins/gnss_range/range_rate.hpp"
#include "../../plugins/gnss_range/single_point.hpp"
#include "../plugins/bind.hpp"
#include "../plugins/model_check.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"
#include "sky.hpp"
#include "strapdown/earth.hpp"
#include "support/navigation_kinds.hpp"

namespace models_test {

using namespace binnacle;
using namespace binnacle::gnss_range;
using namespace binnacle::test;
using Eigen::Vector3d;
using nlohmann::json;

namespace {

const Vector3d home(0.61, 2.21, 400.0);  // lat, lon, height

/// A vehicle under a sky: its truth, a sample of what it measures, and the auxiliary channels.
struct Scene {
  Sky sky;
  Vector3d r0 = strapdown::ecef_from_lla(home);
  Vector3d v_n{30, -20, 4};
  Vector3d v_e = strapdown::C_en(home[0], home[1]) * v_n;
  double bias = 0.0021;    // s
  double drift = 1.1e-7;   // s/s
  double label = 9000.25;  // s
  std::vector<double> observations, ephemerides, coefficients{1.1e-8, 7e-9, -6e-8, -6e-8, 9e4, 1.6e4, -1.9e5, -6e4};
  SampleView auxiliary[2];

  Scene() {
    // Truth: at r0, with v_e, when the label says so.
    const double t0 = label - bias;
    const Track track = [=, this](double t) { return Vector3d(r0 + (t - t0) * v_e); };
    const ClockTrack clock = [=, this](double t) { return bias + (t - t0) * drift; };
    observations = sky.observe(label, track, clock);
    ephemerides = sky.ephemeris_rows();
    auxiliary[0] = rows_view(ephemerides, gnss::ephemeris_field_count, 0);
    auxiliary[1].fields = coefficients.data();
    auxiliary[1].available = true;
  }
  /// As single_point reads it, and as the models do, which have fields that this channel lacks.
  SampleView narrow() const { return rows_view(observations, gnss::observation::field_count, nanoseconds(label)); }
  SampleView sample() const {
    wide_ = widened(observations);
    return rows_view(wide_, wide_fields(), nanoseconds(label));
  }
  std::vector<double> ecef() const { return {r0[0], r0[1], r0[2]}; }
  std::vector<double> ecef_velocity() const { return {v_e[0], v_e[1], v_e[2]}; }
  std::vector<double> geodetic() const { return {home[0], home[1], home[2]}; }
  std::vector<double> clock_state() const { return {bias * gnss::speed_of_light, drift * gnss::speed_of_light}; }

 private:
  mutable std::vector<double> wide_;
};

const AdditiveKind ecef_position("position.ecef", 3, "m"), ecef_velocity("velocity.ecef", 3, "m/s"),
    ned_velocity("velocity.ned", 3, "m/s"), receiver_clock("receiver_clock", 2, "m"), galileo(1, "m");
const PositionKind geodetic;

json everything() { return {{"ionosphere", "klobuchar"}, {"troposphere", "saastamoinen"}, {"elevation_mask", 0.1}}; }

}  // namespace

namespace {

/// What single_point makes of a scene.
struct Solution {
  bool is_there = false;
  std::vector<double> ecef, ned;
  Eigen::MatrixXd P, P_ned;
};

Solution solution_of(const SinglePoint& transform, const Scene& scene) {
  const ComponentSpec spec = SinglePoint::spec();
  const binnacle::testing::TransformCaller caller(transform, spec);
  auto memory = caller.fresh_memory(0);
  for (const std::size_t input : {0u, 1u}) caller.on(input, scene.auxiliary[input], memory.data());
  const auto made = caller.on(2, scene.narrow(), memory.data());
  REQUIRE(made.damage.empty());
  Solution s;
  s.is_there = made.samples.size() == 2;
  if (!s.is_there) return s;
  s.ecef = made.samples[0].fields;
  s.ned = made.samples[1].fields;
  s.P = matrix_at(made.samples[0].covariance.data(), 8, 8);
  s.P_ned = matrix_at(made.samples[1].covariance.data(), 8, 8);
  return s;
}

Solution solve(const Scene& scene, const json& parameters) {
  return solution_of(*bind<SinglePoint>({parameters, {}, {}}), scene);
}

}  // namespace

TEST_CASE("a pseudorange made in inertial axes is predicted to a tenth of a millimetre") {
  const Scene scene;
  const auto model =
      bind_by_ephemeris<Pseudorange>({{}, {{"ecef_position", &ecef_position}, {"clock", &receiver_clock}}, {}});
  const PortStates ports{{}, {&ecef_position, scene.ecef()}, {&receiver_clock, scene.clock_state()}, {}};
  Complaints out;
  const Measured m = linearize(*model, scene.sample(), ports, {}, out, scene.auxiliary);
  REQUIRE(m.result);
  REQUIRE(out.empty());
  REQUIRE(m.residual.size() >= 6);
  CHECK(m.residual.cwiseAbs().maxCoeff() < 1e-4);
  REQUIRE(m.keys.size() == static_cast<std::size_t>(m.residual.size()));
  for (std::size_t i = 1; i < m.keys.size(); ++i) CHECK(m.keys[i] > m.keys[i - 1]);
}

TEST_CASE("a range rate by differences of pseudoranges is predicted to a millimetre per second") {
  const Scene scene;
  const auto model = bind_by_ephemeris<RangeRateModel>(
      {{}, {{"ecef_position", &ecef_position}, {"ecef_velocity", &ecef_velocity}, {"clock", &receiver_clock}}, {}});
  const PortStates ports{{},
                         {&ecef_position, scene.ecef()},
                         {},
                         {&ecef_velocity, scene.ecef_velocity()},
                         {&receiver_clock, scene.clock_state()}};
  Complaints out;
  const Measured m = linearize(*model, scene.sample(), ports, {}, out, scene.auxiliary);
  REQUIRE(m.result);
  CHECK(m.residual.cwiseAbs().maxCoeff() < 1e-3);  // the satellites' clocks' rate is first order in v/c as well
}

TEST_CASE("each correction is worth what it should be") {
  const Scene scene;
  const PortStates ports{{}, {&ecef_position, scene.ecef()}, {&receiver_clock, scene.clock_state()}, {}};
  const auto residuals = [&](json parameters) {
    parameters["elevation_mask"] = 0.0;
    const auto model = bind_by_ephemeris<Pseudorange>(
        {parameters, {{"ecef_position", &ecef_position}, {"clock", &receiver_clock}}, {}});
    Complaints out;
    return linearize(*model, scene.sample(), ports, {}, out, scene.auxiliary).residual;
  };
  const Eigen::VectorXd all = residuals(json::object());
  const auto place = gnss::place_from_ecef(scene.r0);
  Eigen::Index row = 0;
  const Eigen::VectorXd without_clock = residuals({{"satellite_clock", false}}),
                        without_delay = residuals({{"group_delay", false}}),
                        without_turn = residuals({{"earth_rotation", false}}),
                        with_iono = residuals({{"ionosphere", "klobuchar"}}),
                        with_tropo = residuals({{"troposphere", "saastamoinen"}}),
                        with_cosecant =
                            residuals({{"troposphere", "saastamoinen"}, {"troposphere_mapping", "cosecant"}}),
                        with_winter = residuals({{"troposphere", "saastamoinen"}, {"day_of_year", 28}});
  for (std::size_t i = 0; i < scene.observations.size(); i += gnss::observation::field_count, ++row) {
    const auto& e = scene.sky.ephemerides[static_cast<std::size_t>(scene.observations[i]) - 101];
    const auto state = Sky::state(e, scene.label - 0.08);
    const auto direction = gnss::direction_in(place.C_en, (state.position - scene.r0).normalized());
    INFO(e.satellite << " at " << direction.elevation);
    // The satellite moves while its clock is not corrected for: up to 1 km/s times 1e-4 s.
    CHECK(std::abs(without_clock[row] - all[row] + gnss::speed_of_light * state.clock) < 0.2);
    CHECK(std::abs(without_delay[row] - all[row] - gnss::speed_of_light * e.group_delay) < 1e-6);
    const double sagnac =
        gnss::omega_e / gnss::speed_of_light * (state.position.x() * scene.r0.y() - state.position.y() * scene.r0.x());
    CHECK(std::abs(without_turn[row] - all[row] - sagnac) < 0.02);
    const double iono = gnss::klobuchar_delay(gnss::read_klobuchar(scene.coefficients.data()), home[0], home[1],
                                              direction.azimuth, direction.elevation, scene.label);
    CHECK(std::abs(with_iono[row] - all[row] + iono) < 0.01);
    CHECK(iono > 1);
    const double tropo = gnss::troposphere_delay(gnss::Mapping::niell, home[0], home[2], direction.elevation, 0).delay;
    CHECK(std::abs(with_tropo[row] - all[row] + tropo) < 0.02);
    const double flat =
        gnss::troposphere_delay(gnss::Mapping::cosecant, home[0], home[2], direction.elevation, 0).delay;
    CHECK(std::abs(with_cosecant[row] - with_tropo[row] + flat - tropo) < 1e-3 * flat);
    // In winter the air is lower.
    const double winter =
        gnss::troposphere_delay(gnss::Mapping::niell, home[0], home[2], direction.elevation, gnss::season_of(28)).delay;
    CHECK(winter > tropo);
    CHECK(std::abs(with_winter[row] - with_tropo[row] + winter - tropo) < 0.05 * (winter - tropo));
  }
}

TEST_CASE("the ionosphere delays BeiDou's B1I by more than L1, as the square of the frequencies") {
  Scene scene;
  for (auto& e : scene.sky.ephemerides) e.satellite += 219;  // G01 becomes C20
  for (std::size_t i = 0; i < scene.observations.size(); i += gnss::observation::field_count)
    scene.observations[i] += 219;
  scene.ephemerides = scene.sky.ephemeris_rows();
  scene.auxiliary[0] = rows_view(scene.ephemerides, gnss::ephemeris_field_count, 0);
  const auto measured = [&](const char* ionosphere) {
    const auto model = bind_by_ephemeris<Pseudorange>({{{"elevation_mask", 0.0}, {"ionosphere", ionosphere}},
                                                       {{"ecef_position", &ecef_position}, {"clock", &receiver_clock}},
                                                       {}});
    const PortStates ports{{}, {&ecef_position, scene.ecef()}, {&receiver_clock, scene.clock_state()}, {}};
    Complaints out;
    return linearize(*model, scene.sample(), ports, {}, out, scene.auxiliary);
  };
  const Measured with = measured("klobuchar"), without = measured("none");
  REQUIRE(with.keys.size() >= 6);
  const auto place = gnss::place_from_ecef(scene.r0);
  for (std::size_t i = 0; i < with.keys.size(); ++i) {
    const auto& e = scene.sky.ephemerides.at(static_cast<std::size_t>(with.keys[i]) - 320);
    const auto direction =
        gnss::direction_in(place.C_en, (Sky::state(e, scene.label - 0.08).position - scene.r0).normalized());
    const double on_L1 = gnss::klobuchar_delay(gnss::read_klobuchar(scene.coefficients.data()), home[0], home[1],
                                               direction.azimuth, direction.elevation, scene.label);
    const auto row = static_cast<Eigen::Index>(i);
    const double ratio = (without.residual[row] - with.residual[row]) / on_L1;
    CHECK(std::abs(ratio - std::pow(1575.42 / 1561.098, 2)) < 2e-3);
  }
}

TEST_CASE("a day of the year that nothing uses is refused") {
  const auto with = [](const json& parameters) {
    return bind_by_ephemeris<Pseudorange>(
        {parameters, {{"ecef_position", &ecef_position}, {"clock", &receiver_clock}}, {}});
  };
  CHECK_NOTHROW(with({{"troposphere", "saastamoinen"}, {"day_of_year", 92}}));
  CHECK_THROWS_AS(with({{"day_of_year", 92}}), ComponentError);
  CHECK_THROWS_AS(with({{"troposphere", "saastamoinen"}, {"troposphere_mapping", "cosecant"}, {"day_of_year", 92}}),
                  ComponentError);
}

TEST_CASE("H of pseudoranges against differences, in either kind of position") {
  const Scene scene;
  // Away from the truth, where residuals are large.
  const std::vector<double> clock{scene.clock_state()[0] + 500, 3};
  const auto check = [&](const Ports& bound, const PortStates& ports) {
    const auto bare = bind_by_ephemeris<Pseudorange>({json::object(), bound, {}});
    REQUIRE_NO_COMPLAINTS(
        check_measurement(*bare, Pseudorange::spec(), scene.sample(), ports, {}, {1e-8}, 1e-8, scene.auxiliary));
    // The atmosphere changes with the place by some 1e-6: all of it is left out of H but the troposphere's by height,
    // which is 1e-3 at the mask and would show.
    const auto model = bind_by_ephemeris<Pseudorange>({everything(), bound, {}});
    REQUIRE_NO_COMPLAINTS(
        check_measurement(*model, Pseudorange::spec(), scene.sample(), ports, {}, {1e-5}, 1e-8, scene.auxiliary));
  };
  std::vector<double> x = scene.ecef();
  x[0] += 300, x[1] -= 200;
  check({{"ecef_position", &ecef_position}, {"clock", &receiver_clock}},
        {{}, {&ecef_position, x, 10}, {&receiver_clock, clock, 1}, {}});
  check({{"position", &geodetic}, {"clock", &receiver_clock}, {"system_offset", &galileo}},
        {{&geodetic, scene.geodetic(), 10, 1e-8}, {}, {&receiver_clock, clock, 1}, {&galileo, {4.0}, 1}});
}

TEST_CASE("H of range rates against differences, in either kind of axes") {
  const Scene scene;
  const auto check = [&](const Ports& bound, const PortStates& ports) {
    const auto model = bind_by_ephemeris<RangeRateModel>({{{"elevation_mask", 0.1}}, bound, {}});
    REQUIRE_NO_COMPLAINTS(
        check_measurement(*model, RangeRateModel::spec(), scene.sample(), ports, {}, {2e-5}, 1e-11, scene.auxiliary));
  };
  const std::vector<double> clock{0, 30};
  check(
      {{"ecef_position", &ecef_position}, {"ecef_velocity", &ecef_velocity}, {"clock", &receiver_clock}},
      {{}, {&ecef_position, scene.ecef(), 100}, {}, {&ecef_velocity, {200, -100, 50}, 1}, {&receiver_clock, clock, 1}});
  check({{"position", &geodetic}, {"velocity", &ned_velocity}, {"clock", &receiver_clock}},
        {{&geodetic, scene.geodetic(), 100, 1e-8},
         {},
         {&ned_velocity, {200, -100, 50}, 1},
         {},
         {&receiver_clock, clock, 1}});
}

TEST_CASE("masks, exclusion and cuts choose the satellites, and both models the same") {
  Scene scene;
  const PortStates ports{{}, {&ecef_position, scene.ecef()}, {&receiver_clock, scene.clock_state()}, {}};
  const PortStates rate_ports{{},
                              {&ecef_position, scene.ecef()},
                              {},
                              {&ecef_velocity, scene.ecef_velocity()},
                              {&receiver_clock, scene.clock_state()}};
  const auto keys = [&](const json& parameters) {
    const auto model = bind_by_ephemeris<Pseudorange>(
        {parameters, {{"ecef_position", &ecef_position}, {"clock", &receiver_clock}}, {}});
    Complaints out;
    const Measured m = linearize(*model, scene.sample(), ports, {}, out, scene.auxiliary);
    const auto rates = bind_by_ephemeris<RangeRateModel>(
        {parameters,
         {{"ecef_position", &ecef_position}, {"ecef_velocity", &ecef_velocity}, {"clock", &receiver_clock}},
         {}});
    REQUIRE(linearize(*rates, scene.sample(), rate_ports, {}, out, scene.auxiliary).keys == m.keys);
    return m.keys;
  };
  const auto place = gnss::place_from_ecef(scene.r0);
  std::vector<std::pair<double, std::int64_t>> by_elevation;
  for (std::size_t i = 0; i < scene.observations.size(); i += gnss::observation::field_count) {
    const auto& e = scene.sky.ephemerides[static_cast<std::size_t>(scene.observations[i]) - 101];
    by_elevation.emplace_back(
        -gnss::direction_in(place.C_en, (Sky::state(e, scene.label).position - scene.r0).normalized()).elevation,
        e.satellite);
  }
  std::sort(by_elevation.begin(), by_elevation.end());
  const auto highest = [&](std::size_t count) {
    std::vector<std::int64_t> result;
    for (std::size_t i = 0; i < count; ++i) result.push_back(by_elevation[i].second);
    std::sort(result.begin(), result.end());
    return result;
  };
  CHECK(keys({{"elevation_mask", 0.0}}).size() == by_elevation.size());
  CHECK(keys({{"max_satellites", 3}}) == highest(3));
  const json cut{{{"from", 9000}, {"to", 9001}, {"satellites", 2}}};
  CHECK(keys({{"cuts", cut}}) == highest(2));
  CHECK(keys({{"cuts", {{{"from", 8000}, {"to", 9000}, {"satellites", 2}}}}, {"elevation_mask", 0.0}}).size() ==
        by_elevation.size());
  const double mask = 0.5 * (-by_elevation[3].first - by_elevation[4].first);
  CHECK(keys({{"elevation_mask", mask}}) == highest(4));
  const std::string first = gnss::satellite_name(by_elevation[0].second);
  const auto left = keys({{"exclude", {first}}});
  CHECK(std::find(left.begin(), left.end(), by_elevation[0].second) == left.end());
  scene.observations[gnss::observation::cn0] = 20;
  CHECK(keys({{"cn0_mask", 30}, {"elevation_mask", 0.0}}).size() == by_elevation.size() - 1);
  REQUIRE_THROWS_AS(bind_by_ephemeris<Pseudorange>(
                        {{{"exclude", {"R01"}}}, {{"ecef_position", &ecef_position}, {"clock", &receiver_clock}}, {}}),
                    ComponentError);
  REQUIRE_THROWS_AS(bind_by_ephemeris<Pseudorange>({{}, {{"clock", &receiver_clock}}, {}}), ComponentError);
}

TEST_CASE("what cannot be measured is refused with a reason") {
  Scene scene;
  const auto model = bind_by_ephemeris<Pseudorange>(
      {everything(), {{"ecef_position", &ecef_position}, {"clock", &receiver_clock}}, {}});
  const PortStates ports{{}, {&ecef_position, scene.ecef()}, {&receiver_clock, scene.clock_state()}, {}};
  const auto reason = [&] {
    Complaints out;
    const Measured m = linearize(*model, scene.sample(), ports, {}, out, scene.auxiliary);
    REQUIRE(m.result.refusal == Refusal::unsupported);
    return std::string(m.result.reason);
  };
  scene.auxiliary[1].available = false;
  CHECK(reason().find("ionosphere") != std::string::npos);
  scene.auxiliary[1].available = true;
  scene.auxiliary[0].rows = 0;
  CHECK(reason().find("ephemeris") != std::string::npos);
  scene.auxiliary[0].available = false;
  CHECK(reason().find("has come yet") != std::string::npos);
}

TEST_CASE("wild numbers in any place are refused or give finite rows") {
  const std::vector<double> wild{0, 1e-300, -1, 1e6, -1e9, 1e16, 1e300, -1e300, std::nan(""), INFINITY};
  const auto ranges =
      bind_by_ephemeris<Pseudorange>({everything(), {{"position", &geodetic}, {"clock", &receiver_clock}}, {}});
  const auto rates = bind_by_ephemeris<RangeRateModel>(
      {everything(), {{"position", &geodetic}, {"velocity", &ned_velocity}, {"clock", &receiver_clock}}, {}});
  const auto solver = bind<SinglePoint>({everything(), {}, {}});
  const auto try_all = [&](const Scene& scene, const std::vector<double>& lla, const std::vector<double>& v,
                           const std::vector<double>& clock, bool is_finite) {
    Complaints out;
    for (const Measured& m :
         {linearize(*ranges, scene.sample(), {{&geodetic, lla}, {}, {&receiver_clock, clock}, {}}, {}, out,
                    scene.auxiliary),
          linearize(*rates, scene.sample(), {{&geodetic, lla}, {}, {&ned_velocity, v}, {}, {&receiver_clock, clock}},
                    {}, out, scene.auxiliary)}) {
      if (!m.result || !is_finite) continue;
      bool all = m.residual.allFinite() && m.R.allFinite();
      for (const auto& H : m.H) all = all && H.allFinite();
      CHECK(all);
    }
    CHECK(out.empty());
    const Solution s = solution_of(*solver, scene);
    if (s.is_there) CHECK((vector_at<3>(s.ecef.data()).allFinite() && s.P.allFinite()));
  };
  const Scene scene;
  const std::vector<double> lla = scene.geodetic(), v{1, 2, 3}, clock = scene.clock_state();
  for (const double number : wild) {
    const bool is_finite = std::isfinite(number);
    for (std::size_t i = 0; i < 3; ++i) {
      auto place = lla, speed = v;
      place[i] = speed[i] = number;
      try_all(scene, place, v, clock, is_finite);
      try_all(scene, lla, speed, clock, is_finite);
    }
    try_all(scene, lla, v, {number, number}, is_finite);
    for (std::size_t field = 0; field < gnss::observation::field_count; ++field) {
      Scene broken;
      broken.observations[field] = number;
      try_all(broken, lla, v, clock, true);
    }
    for (std::size_t field = 0; field < gnss::ephemeris_field_count; ++field) {
      Scene broken;
      broken.ephemerides[field] = broken.ephemerides[field + gnss::ephemeris_field_count * 5] = number;
      broken.auxiliary[0].row_fields = broken.ephemerides.data();
      try_all(broken, lla, v, clock, true);
    }
  }
}

TEST_CASE("R grows towards the horizon, and with the ionosphere") {
  const Scene scene;
  const PortStates ports{{}, {&ecef_position, scene.ecef()}, {&receiver_clock, scene.clock_state()}, {}};
  const auto variances = [&](json parameters) {
    parameters["ionosphere"] = "klobuchar";
    const auto model = bind_by_ephemeris<Pseudorange>(
        {parameters, {{"ecef_position", &ecef_position}, {"clock", &receiver_clock}}, {}});
    Complaints out;
    return Eigen::VectorXd(linearize(*model, scene.sample(), ports, {}, out, scene.auxiliary).R.diagonal());
  };
  const Eigen::VectorXd flat = variances({{"sigma", 3}}), steep = variances({{"sigma", 3}, {"sigma_elevation", 1}}),
                        iono = variances({{"sigma", 3}, {"sigma_ionosphere", 0.5}}),
                        reported = variances({{"sigma", 3}, {"sigma_accuracy", 2}});
  const auto place = gnss::place_from_ecef(scene.r0);
  CHECK((flat.array() == 9).all());
  CHECK(((reported.array() - 25).abs() < 1e-12).all());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < scene.observations.size(); i += gnss::observation::field_count) {
    const auto& e = scene.sky.ephemerides[static_cast<std::size_t>(scene.observations[i]) - 101];
    const auto direction =
        gnss::direction_in(place.C_en, (Sky::state(e, scene.label - 0.08).position - scene.r0).normalized());
    if (direction.elevation < 10 * M_PI / 180) continue;
    const double sine = std::sin(direction.elevation);
    CHECK(std::abs(steep[row] - 9 - 1 / (sine * sine)) < 1e-3 / (sine * sine));
    const double delay = gnss::klobuchar_delay(gnss::read_klobuchar(scene.coefficients.data()), home[0], home[1],
                                               direction.azimuth, direction.elevation, scene.label);
    CHECK(std::abs(std::sqrt(iono[row] - 9) - 0.5 * delay) < 0.01);
    ++row;
  }
  CHECK(row == flat.size());
}

TEST_CASE("the receiver's clock and the ECEF process: transition and noise") {
  const auto steps = [](double seconds_long) { return Step{0, nanoseconds(seconds_long), seconds_long, {}}; };
  const auto parts = [&] {
    std::vector<Step> list;
    for (int i = 0; i < 200; ++i) list.push_back({nanoseconds(0.01 * i), nanoseconds(0.01 * (i + 1)), 0.01, {}});
    return list;
  }();
  {
    const auto model = bind<ClockProcess>({{{"S_f", 0.009}, {"S_g", 0.0355}}, {{"clock", &receiver_clock}}, {}});
    const ProcessCheck check(*model, ClockProcess::spec());
    const PortStates ports{{&receiver_clock, {100, -3}, 1}};
    REQUIRE_NO_COMPLAINTS(check.transition(ports, steps(2), {}, {1e-9}));
    REQUIRE_NO_COMPLAINTS(check.noise(ports, steps(2), parts, {}, 1e-9));
    REQUIRE_NO_COMPLAINTS(check.zero_step(ports, steps(0), {}));
    Complaints out;
    const auto Q = check.propagate(ports, steps(2), {}, out).noise.at({0, 0});
    CHECK(std::abs(Q(0, 0) - (0.009 * 2 + 0.0355 * 8 / 3)) < 1e-12);
    CHECK(std::abs(Q(1, 1) - 0.0355 * 2) < 1e-12);
  }
  {
    const auto model = bind<EcefPv>(
        {{{"S_a", 0.12}, {"S_v", 0.03}}, {{"position", &ecef_position}, {"velocity", &ecef_velocity}}, {}});
    const ProcessCheck check(*model, EcefPv::spec());
    const PortStates ports{{&ecef_position, {-4e6, 3e6, 4e6}, 1, 1e-9}, {&ecef_velocity, {1, 2, 3}, 1}};
    REQUIRE_NO_COMPLAINTS(check.transition(ports, steps(2), {}, {1e-9}));
    REQUIRE_NO_COMPLAINTS(check.noise(ports, steps(2), parts, {}, 1e-9));
    REQUIRE_NO_COMPLAINTS(check.zero_step(ports, steps(0), {}));
    Complaints out;
    const auto noise = check.propagate(ports, steps(2), {}, out).noise;
    CHECK(std::abs(noise.at({0, 0})(1, 1) - (0.12 * 8 / 3 + 0.06)) < 1e-12);
    CHECK(std::abs(noise.at({1, 1})(2, 2) - 0.24) < 1e-12);
  }
}

TEST_CASE("blocks, and an ECEF antenna as geodetic blocks") {
  REQUIRE_NO_COMPLAINTS(check_block(*bind<ClockBlock>(), {1e5, -3}, 1e4, 1e-9));
  REQUIRE_NO_COMPLAINTS(check_block(*bind<EcefPosition>(), {-4e6, 3e6, 4e6}, 1e4, 1e-8));
  REQUIRE_NO_COMPLAINTS(check_block(*bind<EcefVelocity>(), {10, -3, 1}, 100, 1e-12));
  const Scene scene;
  {
    const auto model = bind<GeodeticPosition>({{}, {{"ecef_position", &ecef_position}}, {}});
    // Metres by the radii at the estimate: a chart, good to step · tan(lat) / R.
    REQUIRE_NO_COMPLAINTS(check_derived(*model, GeodeticPosition::spec(), geodetic,
                                        {{&ecef_position, scene.ecef(), 10}}, {}, {1e-6}, 1e-8));
  }
  const auto model =
      bind<NedVelocity>({{}, {{"ecef_position", &ecef_position}, {"ecef_velocity", &ecef_velocity}}, {}});
  REQUIRE_NO_COMPLAINTS(
      check_derived(*model, NedVelocity::spec(), ned_velocity,
                    {{&ecef_position, scene.ecef(), 1000}, {&ecef_velocity, scene.ecef_velocity(), 1}}, {}, {1e-6},
                    1e-12));
  const std::vector<double> r = scene.ecef(), v = scene.ecef_velocity();
  const double* x[] = {r.data(), v.data()};
  double value[3];
  DerivedOutput made{{value, 3}, {}};
  REQUIRE(model->evaluate({x, {}}, made));
  CHECK((vector_at<3>(static_cast<const double*>(value)) - scene.v_n).norm() < 1e-9);
}

TEST_CASE("a single-point solution from a cold start finds position, velocity and clock") {
  const Scene scene;
  const Solution s = solve(scene, {{"pseudorange", {{"sigma", 2}}}, {"range_rate", {{"sigma", 0.1}}}});
  REQUIRE(s.is_there);
  CHECK((vector_at<3>(s.ecef.data()) - scene.r0).norm() < 1e-3);
  CHECK((vector_at<3>(s.ecef.data() + 3) - scene.v_e).norm() < 3e-3);
  CHECK(std::abs(s.ecef[6] - scene.clock_state()[0]) < 1e-3);
  CHECK(std::abs(s.ecef[7] - scene.clock_state()[1]) < 3e-3);
  CHECK((vector_at<3>(s.ned.data() + 3) - scene.v_n).norm() < 3e-3);
  CHECK(std::abs(s.ned[0] - home[0]) < 1e-9);
  // Its covariance is that of the fit, and the same in either axes.
  const Eigen::Matrix3d C = strapdown::C_en(home[0], home[1]);
  CHECK((C.transpose() * s.P.topLeftCorner<3, 3>() * C).isApprox(s.P_ned.topLeftCorner<3, 3>(), 1e-6));
  CHECK((C.transpose() * s.P.block<3, 1>(0, 6)).isApprox(s.P_ned.block<3, 1>(0, 6), 1e-6));
  CHECK(std::abs(s.ned[11] - std::sqrt(s.P_ned(0, 0))) < 1e-12);
  const double gdop = s.ecef[10];
  CHECK(std::abs(std::sqrt(s.P.topLeftCorner<3, 3>().trace() + s.P(6, 6)) - 2 * gdop) < 1e-6 * gdop);
}

TEST_CASE("a satellite with 1 km error is left out of a single-point solution and reported") {
  Scene scene;
  const auto satellites = scene.observations.size() / gnss::observation::field_count;
  REQUIRE(satellites >= 6);
  for (std::size_t bad = 0; bad < satellites; ++bad) {
    Scene broken;
    broken.observations[bad * gnss::observation::field_count + gnss::observation::pseudorange] += 1000;
    const Solution s = solve(broken, {{"elevation_mask", 0.0}});
    INFO("satellite " << bad);
    REQUIRE(s.is_there);
    CHECK(s.ecef[9] == 1);
    CHECK((vector_at<3>(s.ecef.data()) - broken.r0).norm() < 1e-2);
  }
}

TEST_CASE("without four satellites there is no single-point solution, without range rates no velocity") {
  Scene scene;
  CHECK_FALSE(solve(scene, {{"max_satellites", 3}}).is_there);
  CHECK_FALSE(solve(scene, {{"max_gdop", 0.5}}).is_there);
  for (std::size_t i = 0; i < scene.observations.size(); i += gnss::observation::field_count)
    scene.observations[i + gnss::observation::range_rate] = std::nan("");
  const Solution s = solve(scene, {{"unknown_speed", 50}});
  REQUIRE(s.is_there);
  CHECK(s.ecef[3] == 0);
  CHECK(s.P(3, 3) == 2500);
}

}  // namespace models_test
