// SPDX-License-Identifier: Apache-2.0
// The ship simulator: its motion against other mathematics, its errors against their statistics, its manners.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "catch.hpp"
#include "ship_simulator/simulator.hpp"
#include "simulation.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"

namespace ship_simulator_test {

using namespace binnacle;
using namespace binnacle::ship_simulator;
using namespace binnacle::simulation;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

using Sim = ShipSimulator;
using Voyage = Simulation<Sim>;
constexpr double degree = std::numbers::pi / 180.0;
constexpr double arcmin = degree / 60.0;

Json paper() { return {{"start", {{"lat", "36.4 deg"}, {"lon", "127.4 deg"}, {"heading", "30 deg"}}}}; }

/// Ten degrees of roll, metres of heave, yaw, a lever arm.
Json stormy() {
  Json config = paper();
  config["start"]["speed"] = "12 m/s";
  config["start"]["heading"] = "-130 deg";
  config["perfect"] = true;
  config["mounting"] = {{"lever_arm", {20, -4, -9}}};
  const auto tone = [](const char* amplitude, double frequency, double phase) {
    return Json{{"tones", Json::array({{{"amplitude", amplitude}, {"frequency", frequency}, {"phase", phase}}})}};
  };
  config["motion"] = {{"roll", tone("10 deg", 0.1, 0.3)}, {"pitch", tone("4 deg", 0.14, 1.0)},
                      {"yaw", tone("3 deg", 0.05, 2.0)},  {"surge", tone("1 m", 0.09, 3.0)},
                      {"sway", tone("1.5 m", 0.08, 4.0)}, {"heave", tone("2 m", 0.12, 5.0)}};
  return config;
}

ShipMotion motion_of(const Json& config) {
  const ParameterValue value = checked<Sim>(config);
  const Parameters p(value), start = p.object("start"), waves = p.object("motion");
  std::array<std::vector<Tone>, freedoms> tones;
  for (std::size_t k = 0; k < freedoms; ++k) tones[k] = read_freedom(waves.object(freedom_name[k]), "");
  return ShipMotion({{start.number("lat"), start.number("lon"), start.number("height")},
                     start.number("speed"),
                     start.number("heading"),
                     start.number("roll"),
                     start.number("pitch")},
                    tones);
}

std::vector<double> phases_of(const ShipMotion& motion) {
  std::vector<double> phases;
  for (const auto& tones : motion.tones())
    for (const Tone& tone : tones) phases.push_back(tone.phase);
  return phases;
}

double metres(const Vector3d& lla, const Vector3d& from) { return strapdown::position_minus(lla, from).norm(); }

struct Drift {
  double position = 0, velocity = 0, attitude = 0;
};

/// The strapdown mechanization, which knows nothing of the simulator, started at the first truth: how far it drifts off.
Drift drift_of(const Json& config, bool knows_neighbours = true) {
  Voyage voyage(config);
  std::optional<strapdown::Navigation> nav;
  strapdown::Previous previous;
  std::optional<Emitted> truth;
  Drift worst;
  while (const auto sample = voyage.next()) {
    if (sample->channel == Sim::truth) {
      truth = *sample;
      if (!nav) nav = {sample->triple(0), sample->triple(3), sample->attitude(6)};
    } else if (sample->channel == Sim::imu) {
      const strapdown::Increment increment{seconds(sample->t - sample->t0), sample->triple(0), sample->triple(3)};
      nav = strapdown::advance(*nav, increment, knows_neighbours ? previous : strapdown::Previous{});
      previous = strapdown::remember(previous, increment);
      if (truth->t != sample->t) continue;
      worst.position = std::max(worst.position, metres(truth->triple(0), nav->lla));
      worst.velocity = std::max(worst.velocity, (truth->triple(3) - nav->v_n).norm());
      worst.attitude = std::max(worst.attitude, strapdown::attitude_minus(truth->attitude(6), nav->q_nb).norm());
    }
  }
  return worst;
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Within 4.5 σ of a standard deviation estimated from n values.
bool is_rms(double found, double expected, std::size_t n) {
  return std::abs(found / expected - 1.0) < 4.5 / std::sqrt(2.0 * static_cast<double>(n));
}

}  // namespace

// ---- the motion

TEST_CASE(
    "ship: free of errors, a mechanization of the increments reproduces the truth, in a storm and at a lever arm") {
  for (const bool calm : {true, false}) {
    Json config = calm ? paper() : stormy();
    config["perfect"] = true;
    config["imu_rate"] = 200;
    const Drift drift = drift_of(config);
    INFO((calm ? "calm: " : "storm: ") << drift.position << " m, " << drift.velocity << " m/s, " << drift.attitude);
    REQUIRE(drift.position < (calm ? 1e-6 : 1e-4));
    REQUIRE(drift.velocity < (calm ? 1e-7 : 1e-5));
    REQUIRE(drift.attitude < (calm ? 1e-10 : 1e-9));
  }
}

TEST_CASE("ship: specific force and angular rate at a lever arm are those of its path through inertial space") {
  const Json config = stormy();
  const ShipMotion motion = motion_of(config);
  const auto phases = phases_of(motion);
  const Vector3d lever_arm(20, -4, -9);
  const double earth_rate = 7.292115e-5, h = 0.2;
  const auto turned = [&](double t) -> Matrix3d {
    return Eigen::AngleAxisd(earth_rate * t, Vector3d::UnitZ()).toRotationMatrix();
  };
  for (double t = 1.0; t < 60.0; t += 3.7) {
    const auto path = [&](int i) -> Vector3d {  // metres, less a constant to keep digits
      const double at = t + i * h;
      const Vector3d r0 = strapdown::ecef_from_lla(at_lever_arm(motion.at(t, phases.data()), lever_arm).lla);
      const Vector3d r = strapdown::ecef_from_lla(at_lever_arm(motion.at(at, phases.data()), lever_arm).lla);
      return turned(i * h) * r - r0;
    };
    // second derivative, eighth order
    const Vector3d acceleration = (-205.0 / 72 * path(0) + 8.0 / 5 * (path(1) + path(-1)) - 0.2 * (path(2) + path(-2)) +
                                   8.0 / 315 * (path(3) + path(-3)) - 1.0 / 560 * (path(4) + path(-4))) /
                                  (h * h);
    const State now = motion.at(t, phases.data());
    const Point point = at_lever_arm(now, lever_arm);
    const Vector3d r = strapdown::ecef_from_lla(point.lla), axis(0, 0, earth_rate);
    const Matrix3d C_en = strapdown::C_en(point.lla[0], point.lla[1]);
    const Vector3d attraction =
        C_en * Vector3d(0, 0, strapdown::gravity(point.lla[0], point.lla[2]).down) + axis.cross(axis.cross(r));
    const Matrix3d C_em = C_en * strapdown::dcm_from_quaternion(point.q_nm);
    const auto felt = inertial_at_lever_arm(now, lever_arm);
    INFO("t = " << t << ": " << (felt.f_b - C_em.transpose() * (acceleration - attraction)).norm());
    REQUIRE((felt.f_b - C_em.transpose() * (acceleration - attraction)).norm() < 1e-6);

    const double d = 1e-3;
    const auto q = [&](double at) { return inertial_attitude(motion.at(at, phases.data()), at); };
    const Vector3d turn =
        strapdown::quaternion_log(strapdown::quaternion_product(strapdown::quaternion_conjugate(q(t - d)), q(t + d)));
    REQUIRE((turn / (2 * d) - felt.omega_ib_b).norm() < 1e-7);
    REQUIRE((motion.around(t + 0.004, 0.004, phases.data())[0].lla - now.lla).norm() < 1e-13);
    REQUIRE((motion.around(t + 0.004, 0.004, phases.data())[0].euler_acceleration - now.euler_acceleration).norm() <
            1e-13);
  }
}

TEST_CASE("ship: increments add up, whatever the rate") {
  Json config = stormy();
  config["truth_rate"] = 0;
  config["mins"]["rate"] = 0;
  config["duration"] = "20 s";
  config["imu_rate"] = 1;
  const auto slow = Voyage(config).of(Sim::imu);
  config["imu_rate"] = 100;
  const auto fast = Voyage(config).of(Sim::imu);
  REQUIRE(slow.size() == 20);
  REQUIRE(fast.size() == 2000);
  for (std::size_t i = 0; i < slow.size(); ++i) {
    std::array<double, 6> sum{};
    for (std::size_t k = 0; k < 600; ++k) sum[k % 6] += fast[100 * i + k / 6].fields[k % 6];
    for (std::size_t k = 0; k < 6; ++k) REQUIRE(std::abs(sum[k] - slow[i].fields[k]) < (k < 3 ? 5e-11 : 1e-9));
  }
}

TEST_CASE("ship: rotation vectors compose to the attitude, to the last digits") {
  Json config = stormy();
  config["increments"] = "rotation_vector";
  config["duration"] = "60 s";
  config["mins"]["rate"] = 0;
  const auto samples = Voyage(config).rest();
  Vector4d q_is, first;  // from the first truth, in inertial axes that start as those of the earth
  const auto inertial_q = [](const Emitted& truth) {
    const Matrix3d C_en = strapdown::C_en(truth.fields[0], truth.fields[1]);
    const double angle = strapdown::wgs84::omega_ie * seconds(truth.t);
    const Matrix3d C_ie = Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
    return strapdown::quaternion_product(strapdown::quaternion_from_dcm(C_ie * C_en), truth.attitude(6));
  };
  double worst = 0, plain = 0;
  const Emitted* truth = nullptr;
  Vector4d from_rates;
  config["increments"] = "rate";
  const auto rates = Voyage(config).of(Sim::imu);
  std::size_t i = 0;
  for (const auto& sample : samples) {
    if (sample.channel == Sim::truth) {
      if (!truth) q_is = from_rates = inertial_q(sample);
      truth = &sample;
    } else if (sample.channel == Sim::imu) {
      q_is = strapdown::quaternion_product(q_is, strapdown::quaternion_exp(sample.triple(0)));
      from_rates = strapdown::quaternion_product(from_rates, strapdown::quaternion_exp(rates[i++].triple(0)));
      if (truth->t != sample.t) continue;
      worst = std::max(worst, strapdown::attitude_minus(inertial_q(*truth), q_is).norm());
      plain = std::max(plain, strapdown::attitude_minus(inertial_q(*truth), from_rates).norm());
    }
  }
  INFO(worst << " rad, as if rates were rotation vectors " << plain);
  REQUIRE(worst < 2e-13);
  REQUIRE(plain > 1e-9);
}

TEST_CASE("ship: the slave is where the lever arm ends, turned by the mounting") {
  Json config = stormy();
  config["mounting"]["misalignment"] = {"1 deg", "-2 deg", "3 deg"};
  config["duration"] = "10 s";
  const auto samples = Voyage(config).rest();
  const Vector3d m(1 * degree, -2 * degree, 3 * degree);
  Matrix3d nominal;
  nominal << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  const Emitted* truth = nullptr;
  int compared = 0;
  for (const auto& sample : samples) {
    if (sample.channel == Sim::truth) truth = &sample;
    if (sample.channel == Sim::mounting) REQUIRE(sample.triple(0) == m);
    if (sample.channel != Sim::mins) continue;
    REQUIRE(truth->t == sample.t);
    const Matrix3d C_nm = strapdown::dcm_from_quaternion(sample.attitude(6));
    const Vector3d arm_e = strapdown::ecef_from_lla(truth->triple(0)) - strapdown::ecef_from_lla(sample.triple(3));
    REQUIRE((arm_e - strapdown::C_en(sample.fields[3], sample.fields[4]) * C_nm * Vector3d(20, -4, -9)).norm() < 1e-8);
    const Matrix3d C_ms = strapdown::dcm_from_quaternion(strapdown::quaternion_exp(m)) * nominal;
    const Matrix3d C_ns = strapdown::dcm_from_quaternion(truth->attitude(6));
    REQUIRE((C_ns - C_nm * C_ms).norm() < 2e-5);  // the navigation axes differ by lever_arm/R
    REQUIRE((C_nm * Vector3d(0, 0, -1)).dot(C_ns * Vector3d(1, 0, 0)) > 0.99);  // its x axis stands up
    const Vector3d level = strapdown::attitude_minus(truth->attitude(9), sample.attitude(6));
    REQUIRE((level - C_nm * m).norm() < 1e-5);
    ++compared;
  }
  REQUIRE(compared == 50);
}

TEST_CASE("ship: the velocity is that of the position, at the slave too") {
  Json config = stormy();
  config["truth_rate"] = 100;
  config["duration"] = "10 s";
  const auto truth = Voyage(config).of(Sim::truth);
  for (std::size_t i = 2; i + 2 < truth.size(); i += 7) {
    const auto moved = [&](std::size_t k) { return strapdown::position_minus(truth[k].triple(0), truth[i].triple(0)); };
    const Vector3d v = (8 * (moved(i + 1) - moved(i - 1)) - moved(i + 2) + moved(i - 2)) / 0.12;
    REQUIRE((v - truth[i].triple(3)).norm() < 1e-6);
  }
}

TEST_CASE("ship: tones of a spectrum have its variance, band by band") {
  const double omega = 0.6, zeta = 0.2, sigma = 0.05;
  const int count = 100;
  const auto tones = tones_of_spectrum(omega, zeta, sigma, count);
  REQUIRE(tones.size() == count);
  double variance = 0, rate_variance = 0;
  for (const Tone& tone : tones) {
    variance += 0.5 * tone.amplitude * tone.amplitude;
    rate_variance += 0.5 * std::pow(tone.amplitude * tone.omega, 2);
    REQUIRE(std::isnan(tone.phase));
  }
  REQUIRE(std::abs(variance / (sigma * sigma) - 1) < 1e-12);
  REQUIRE(std::abs(rate_variance / std::pow(sigma * omega, 2) - 1) < 0.08);  // the process has σ²ω², its tail a part
  const double q = 4 * zeta * std::pow(omega, 3) * sigma * sigma;
  double below = 0, nu = 0;
  for (std::size_t i = 0; i < tones.size(); ++i) {
    const double step = 1e-4;
    for (; nu < tones[i].omega; nu += step) {
      const double at = nu + 0.5 * step;
      below +=
          step * q / std::numbers::pi / (std::pow(omega * omega - at * at, 2) + std::pow(2 * zeta * omega * at, 2));
    }
    REQUIRE(std::abs(below / (sigma * sigma) - (static_cast<double>(i) + 0.5) / count) < 1e-3);
  }
}

// ---- the samples

TEST_CASE("ship: samples come in order of time, the first of the MINS after one interval") {
  Json config = paper();
  config["start_time"] = 500;
  const auto samples = Voyage(config).rest();
  REQUIRE(samples.front().channel == Sim::initial);
  std::array<int, 5> count{};
  Time last = nanoseconds(500), imu_end = last;
  bool has_mins = false;
  for (const auto& sample : samples) {
    REQUIRE(sample.t >= last);
    last = sample.t;
    ++count[static_cast<std::size_t>(sample.channel)];
    for (const double field : sample.fields) REQUIRE(std::isfinite(field));
    if (sample.channel == Sim::imu) {
      REQUIRE(sample.t0 == imu_end);
      imu_end = sample.t;
    }
    if (sample.channel == Sim::mins && !has_mins) REQUIRE(sample.t == nanoseconds(500.2));
    has_mins = has_mins || sample.channel == Sim::mins;
  }
  REQUIRE(last == nanoseconds(600));
  REQUIRE(count == std::array{10000, 500, 501, 1, 501});
}

TEST_CASE("ship: equal seeds give equal samples, other seeds other ones, and restored memory continues") {
  Json config = paper();
  config["duration"] = "5 s";
  config["increments"] = "rotation_vector";
  Voyage voyage(config, 5);
  const auto first = voyage.rest();
  voyage.restart(5);
  REQUIRE(voyage.rest() == first);
  const auto other = Voyage(config, 6).rest();
  REQUIRE(other.size() == first.size());
  for (std::size_t i = 0; i < first.size(); ++i) REQUIRE(!(other[i] == first[i]));
  voyage.restart(5);
  for (int i = 0; i < 300; ++i) voyage.next();
  const auto snapshot = voyage.memory();
  const auto uninterrupted = voyage.rest();
  Voyage resumed(config, 99);
  resumed.memory() = snapshot;
  REQUIRE(resumed.rest() == uninterrupted);
}

TEST_CASE("ship: waves and misalignment do not depend on the sizes of errors") {
  Json config = paper();
  config["duration"] = "2 s";
  const auto base = Voyage(config, 3).rest();
  config["gyro"] = {{"noise", 0}, {"bias", "5 deg/h"}};
  config["mins"] = {{"noise_scale", 3}};
  const auto changed = Voyage(config, 3).rest();
  REQUIRE(base.size() == changed.size());
  for (std::size_t i = 0; i < base.size(); ++i)
    if (base[i].channel == Sim::truth || base[i].channel == Sim::mounting) REQUIRE(base[i] == changed[i]);
}

// ---- the statistics of the errors

TEST_CASE("ship: the MINS scatters as specified, times the scale of its noise, about its constant errors") {
  for (const double scale : {1.0, 3.0}) {
    Json config = paper();
    config["duration"] = "400 s";
    config["imu_rate"] = 1;
    config["mins"] = {{"noise_scale", scale}, {"attitude_bias", 0}, {"position_noise", 2}};
    const auto noisy = Voyage(config, 2).of(Sim::mins);
    config["perfect"] = true;
    const auto exact = Voyage(config, 2).of(Sim::mins);
    std::array<std::vector<double>, 3> errors;
    double neighbours = 0;
    for (std::size_t i = 0; i < noisy.size(); ++i) {
      const Vector3d p = strapdown::position_minus(noisy[i].triple(3), exact[i].triple(3));
      for (std::size_t k = 0; k < 3; ++k) {
        errors[0].push_back(noisy[i].fields[k] - exact[i].fields[k]);
        errors[1].push_back(p[static_cast<long>(k)]);
        errors[2].push_back(noisy[i].fields[6 + k] - exact[i].fields[6 + k]);
        if (i > 0) neighbours += errors[2][3 * i + k] * errors[2][3 * i + k - 3];
      }
    }
    const std::size_t n = errors[0].size();
    REQUIRE(is_rms(rms(errors[0]), 0.257 * scale, n));
    REQUIRE(is_rms(rms(errors[1]), 2 * scale, n));
    REQUIRE(is_rms(rms(errors[2]), 0.2 * arcmin * scale, n));
    REQUIRE(std::abs(neighbours) < 4.5 * std::sqrt(static_cast<double>(n)) * std::pow(0.2 * arcmin * scale, 2));
  }
}

TEST_CASE("ship: what is drawn once a run has its deviations over runs") {
  Json config = paper();
  config["duration"] = "0.2 s";
  config["gyro"] = {{"noise", 0}, {"scale", 0}, {"misalignment", 0}, {"bias", "0.2 deg/h"}};
  config["accel"] = {{"noise", 0}, {"scale", 0}, {"misalignment", "1 arcmin"}, {"bias", 0}};
  config["mins"] = {{"noise_scale", 0}, {"velocity_bias", 0.5}};
  Json perfect = config;
  perfect["perfect"] = true;
  Voyage drawn(config), exact(perfect);
  std::array<std::vector<double>, 6> found;
  const auto pick = [](const std::vector<Emitted>& samples, int channel) {
    for (const auto& sample : samples)
      if (sample.channel == channel) return sample;
    return Emitted{};
  };
  for (std::uint64_t run = 0; run < 400; ++run) {
    drawn.restart(run), exact.restart(run);
    const auto a = drawn.rest(), b = exact.rest();
    const Emitted imu = pick(a, Sim::imu), perfect_imu = pick(b, Sim::imu);
    const Emitted mins = pick(a, Sim::mins), perfect_mins = pick(b, Sim::mins);
    const Emitted mounting = pick(a, Sim::mounting);
    const Emitted initial = pick(a, Sim::initial), truth = pick(a, Sim::truth);
    for (std::size_t k = 0; k < 3; ++k) {
      found[0].push_back((imu.fields[k] - perfect_imu.fields[k]) / 0.01);
      found[2].push_back(mins.fields[k] - perfect_mins.fields[k]);
      if (k < 2) found[3].push_back(mins.fields[6 + k] - perfect_mins.fields[6 + k]);
      found[4].push_back(mounting.fields[k]);
    }
    found[5].push_back(mins.fields[8] - perfect_mins.fields[8]);
    // specific force is along x: what y and z show of it is their lean
    for (const std::size_t k : {std::size_t{4}, std::size_t{5}})
      found[1].push_back((imu.fields[k] - perfect_imu.fields[k]) / perfect_imu.fields[3]);
    // the initial attitude is that of the MINS, turned by the nominal mounting
    const Vector3d error = strapdown::attitude_minus(truth.attitude(9), initial.attitude(9));
    const Vector3d expected = strapdown::dcm_from_quaternion(mins.attitude(6)) *
                              (mounting.triple(0) - (mins.triple(6) - perfect_mins.triple(6)));
    REQUIRE((error - expected).norm() < 5e-3 * expected.norm() + 1e-6);
  }
  REQUIRE(is_rms(rms(found[0]), 0.2 * degree / 3600, found[0].size()));
  REQUIRE(is_rms(rms(found[1]), arcmin, found[1].size() / 2));
  REQUIRE(is_rms(rms(found[2]), 0.5, found[2].size()));
  REQUIRE(is_rms(rms(found[3]), arcmin, found[3].size()));
  REQUIRE(is_rms(rms(found[4]), degree, found[4].size()));
  REQUIRE(is_rms(rms(found[5]), 3 * arcmin, found[5].size()));
}

TEST_CASE("ship: sensor noise of 10 deg/h over 0.1 s is a random walk of that density") {
  Json config = paper();
  config["duration"] = "100 s";
  config["mins"]["rate"] = 0;
  config["truth_rate"] = 0;
  for (const char* sensor : {"gyro", "accel"}) config[sensor] = {{"bias", 0}, {"scale", 0}, {"misalignment", 0}};
  const auto noisy = Voyage(config, 8).of(Sim::imu);
  config["perfect"] = true;
  const auto exact = Voyage(config, 8).of(Sim::imu);
  std::array<std::vector<double>, 2> errors;
  for (std::size_t i = 0; i < noisy.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k) errors[k / 3].push_back(noisy[i].fields[k] - exact[i].fields[k]);
  const double root = std::sqrt(0.1 * 0.01);  // density² · interval
  REQUIRE(is_rms(rms(errors[0]), 10 * degree / 3600 * root, errors[0].size()));
  REQUIRE(is_rms(rms(errors[1]), 1500e-6 * 9.80665 * root, errors[1].size()));
}

TEST_CASE("ship: an initial estimate from the truth has the errors and states the covariance that are specified") {
  Json config = paper();
  config["duration"] = "0.01 s";
  config["initial"] = {{"from", "truth"},
                       {"error", {{"position", 3}, {"velocity", 0.2}}},
                       {"sigma", {{"attitude", "1 deg"}, {"velocity", 0.3}, {"position", 7}}}};
  Voyage voyage(config);
  std::array<std::vector<double>, 4> found;
  for (std::uint64_t run = 0; run < 500; ++run) {
    voyage.restart(run);
    const auto initial = *voyage.next(), truth = *voyage.next();
    REQUIRE(initial.channel == Sim::initial);
    REQUIRE(truth.channel == Sim::truth);
    const Vector3d p = strapdown::position_minus(truth.triple(0), initial.triple(0));
    const Vector3d a = strapdown::attitude_minus(truth.attitude(6), initial.attitude(6));
    for (long k = 0; k < 3; ++k) {
      found[0].push_back(p[k]);
      found[1].push_back((truth.triple(3) - initial.triple(3))[k]);
      found[k == 2 ? 3 : 2].push_back(a[k]);
    }
    REQUIRE(initial.covariance[0] == 49.0);
    REQUIRE(std::abs(initial.covariance[40] - 0.09) < 1e-15);
    REQUIRE(std::abs(initial.covariance[80] - degree * degree) < 1e-15);
    REQUIRE(initial.covariance[1] == 0.0);
  }
  REQUIRE(is_rms(rms(found[0]), 3, found[0].size()));
  REQUIRE(is_rms(rms(found[1]), 0.2, found[1].size()));
  REQUIRE(is_rms(rms(found[2]), arcmin, found[2].size()));
  REQUIRE(is_rms(rms(found[3]), 3 * arcmin, found[3].size()));
}

TEST_CASE("ship: refuses a mounting that is no rotation, and tones beside a spectrum") {
  const auto pointer_of = [](Json more) -> std::string {
    Json config = paper();
    config.update(more);
    try {
      Voyage voyage(config);
    } catch (const ComponentError& error) {
      return error.pointer();
    }
    return "accepted";
  };
  REQUIRE(pointer_of({{"mounting", {{"nominal", {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}}}}) == "/mounting/nominal");
  REQUIRE(pointer_of(Json::parse(R"({"motion": {"roll": {"tones": [{"amplitude": 1, "frequency": 1}],
      "spectrum": {"omega": 1, "zeta": 0.1, "sigma": 1}}}})")) == "/motion/roll/tones");
  REQUIRE(pointer_of({{"duration", "40 day"}}) == "/duration");
  const Json example = Json::parse(Sim::spec().example);
  REQUIRE(pointer_of(example) == "accepted");
}

}  // namespace ship_simulator_test
