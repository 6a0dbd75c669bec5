// SPDX-License-Identifier: Apache-2.0
// strapdown/mechanization.hpp against an analytic trajectory whose increments come from quadrature, not from itself.
#include "catch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"

namespace strapdown_mechanization_test {

using namespace binnacle::strapdown;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double degree = pi / 180.0;

/// x(t) = start + slope t + Σ amplitude sin(rate t + phase), with its derivatives.
struct Channel {
  double start = 0.0, slope = 0.0;
  struct Tone {
    double amplitude, rate, phase;
  };
  std::vector<Tone> tones;

  struct Value {
    double x, d, dd;
  };
  Value at(double t) const {
    Value v{start + slope * t, slope, 0.0};
    for (const Tone& tone : tones) {
      const double s = std::sin(tone.rate * t + tone.phase), c = std::cos(tone.rate * t + tone.phase);
      v.x += tone.amplitude * s;
      v.d += tone.amplitude * tone.rate * c;
      v.dd -= tone.amplitude * tone.rate * tone.rate * s;
    }
    return v;
  }
};

struct Truth {
  Navigation nav;
  Vector3d omega_ib_b, f_b;
};

struct Trajectory {
  Channel lat, lon, height, roll, pitch, yaw;

  /// Everything from the defining equations and textbook radii; of the library only gravity, which has its own oracle.
  Truth at(double t) const {
    const auto l = lat.at(t), o = lon.at(t), h = height.at(t), r = roll.at(t), p = pitch.at(t), y = yaw.at(t);
    const double a = 6378137.0, f = 1.0 / 298.257223563, e2 = f * (2.0 - f), rate = 7.292115e-5;
    const double s = std::sin(l.x), c = std::cos(l.x), w2 = 1.0 - e2 * s * s;
    const double r_m = a * (1.0 - e2) / std::pow(w2, 1.5), r_t = a / std::sqrt(w2);
    const double d_r_m = 3.0 * a * (1.0 - e2) * e2 * s * c / std::pow(w2, 2.5),
                 d_r_t = a * e2 * s * c / std::pow(w2, 1.5);

    const Vector3d v{l.d * (r_m + h.x), o.d * (r_t + h.x) * c, -h.d};
    const Vector3d v_dot{l.dd * (r_m + h.x) + l.d * (d_r_m * l.d + h.d),
                         o.dd * (r_t + h.x) * c + o.d * ((d_r_t * l.d + h.d) * c - (r_t + h.x) * s * l.d), -h.dd};
    const Vector3d earth{rate * c, 0.0, -rate * s};
    const Vector3d transport{o.d * c, -l.d, -o.d * s};
    const Matrix3d C_nb = (Eigen::AngleAxisd(y.x, Vector3d::UnitZ()) * Eigen::AngleAxisd(p.x, Vector3d::UnitY()) *
                           Eigen::AngleAxisd(r.x, Vector3d::UnitX()))
                              .toRotationMatrix();
    const double cr = std::cos(r.x), sr = std::sin(r.x), cp = std::cos(p.x), sp = std::sin(p.x);
    const Vector3d omega_nb_b{r.d - y.d * sp, p.d * cr + y.d * cp * sr, -p.d * sr + y.d * cp * cr};

    Truth truth;
    truth.nav.lla = {l.x, o.x, h.x};
    truth.nav.v_n = v;
    const Eigen::Quaterniond q(C_nb);
    truth.nav.q_nb = {q.w(), q.x(), q.y(), q.z()};
    truth.omega_ib_b = omega_nb_b + C_nb.transpose() * (earth + transport);
    truth.f_b =
        C_nb.transpose() * (v_dot + (2.0 * earth + transport).cross(v) - Vector3d{0, 0, gravity(l.x, h.x).down});
    return truth;
  }

  /// Gauss-Legendre with seven points.
  Increment increment(double from, double to) const {
    static constexpr std::array<double, 4> node = {0.0, 0.4058451513773972, 0.7415311855993945, 0.9491079123427585};
    static constexpr std::array<double, 4> weight = {0.4179591836734694, 0.3818300505051189, 0.2797053914892766,
                                                     0.1294849661688697};
    const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
    Increment r;
    r.dt = to - from;
    const auto add = [&](double x, double w) {
      const Truth truth = at(middle + half * x);
      r.dtheta += w * half * truth.omega_ib_b;
      r.dv += w * half * truth.f_b;
    };
    add(0.0, weight[0]);
    for (std::size_t i = 1; i < node.size(); ++i) {
      add(node[i], weight[i]);
      add(-node[i], weight[i]);
    }
    return r;
  }
};

/// A vehicle of a few m/s² and 0.3 rad/s that travels about 20 km in ten minutes.
Trajectory vehicle() {
  const double metre = 1.0 / 6.37e6;
  Trajectory t;
  t.lat = {37.0 * degree, 25.0 * metre, {{250.0 * metre, 0.09, 0.3}, {20.0 * metre, 0.31, 1.1}}};
  t.lon = {127.0 * degree, -30.0 * metre, {{300.0 * metre, 0.08, 2.0}, {15.0 * metre, 0.37, 0.2}}};
  t.height = {300.0, 0.2, {{60.0, 0.12, 0.9}, {2.0, 0.7, 0.1}}};
  t.roll = {0.0, 0.0, {{20.0 * degree, 0.70, 0.4}, {3.0 * degree, 1.9, 1.0}}};
  t.pitch = {2.0 * degree, 0.0, {{12.0 * degree, 0.83, 1.7}, {2.0 * degree, 2.3, 0.0}}};
  t.yaw = {50.0 * degree, 0.02, {{20.0 * degree, 0.51, 0.0}}};
  return t;
}

struct Errors {
  double position = 0.0, velocity = 0.0, attitude = 0.0;  ///< largest along the run; m, m/s, rad
};

Errors compare(const Navigation& nav, const Navigation& truth) {
  return {position_minus(nav.lla, truth.lla).norm(), (nav.v_n - truth.v_n).norm(),
          attitude_minus(nav.q_nb, truth.q_nb).norm()};
}

void keep_larger(Errors& all, const Errors& now) {
  all = {std::max(all.position, now.position), std::max(all.velocity, now.velocity),
         std::max(all.attitude, now.attitude)};
}

/// Runs the mechanization over samples whose lengths repeat the given pattern; compares once a second.
Errors run(const Trajectory& trajectory, double seconds, const std::vector<double>& pattern) {
  double period = 0.0;
  for (double dt : pattern) {
    period += dt;
  }
  const int cycles = static_cast<int>(std::lround(seconds / period));
  const int stride = std::max(1, static_cast<int>(std::lround(1.0 / period)));
  Navigation nav = trajectory.at(0.0).nav;
  Previous previous;
  Errors worst;
  for (int cycle = 0; cycle < cycles; ++cycle) {
    double from = cycle * period;
    for (double dt : pattern) {
      const Increment increment = trajectory.increment(from, from + dt);
      nav = advance(nav, increment, previous);
      previous = remember(previous, increment);
      from += dt;
    }
    if ((cycle + 1) % stride == 0) {
      keep_larger(worst, compare(nav, trajectory.at((cycle + 1) * period).nav));
    }
  }
  return worst;
}

Navigation at_rest(double lat) {
  Navigation nav;
  nav.lla = {lat, 2.2, 50.0};
  nav.q_nb = quaternion_from_euler({0.02, -0.03, 1.0});
  return nav;
}

Increment rest_increment(const Navigation& nav, double dt) {
  const Matrix3d C_bn = dcm_from_quaternion(nav.q_nb).transpose();
  return {dt, C_bn * omega_ie_n(nav.lla[0]) * dt, C_bn * Vector3d{0, 0, -gravity(nav.lla[0], nav.lla[2]).down} * dt};
}

}  // namespace

TEST_CASE("ten minutes of a manoeuvring vehicle at 200 Hz", "[strapdown][mechanization]") {
  const Errors e = run(vehicle(), 600.0, {0.005});
  CAPTURE(e.position, e.velocity, e.attitude);
  REQUIRE(e.position < 0.010);
  REQUIRE(e.velocity < 1e-4);
  REQUIRE(e.attitude < 1e-7);
  // What the algorithm is able to do, so that a lost small term is seen: half a step of frame rotation is 0.23 m here.
  REQUIRE(e.position < 5e-4);
  REQUIRE(e.attitude < 2e-9);
}

TEST_CASE("the error falls with the third power of the interval", "[strapdown][mechanization]") {
  for (const std::vector<double>& shape : {std::vector<double>{1.0}, std::vector<double>{0.6, 1.4}}) {
    std::vector<Errors> e;
    for (double dt : {0.04, 0.02, 0.01, 0.005}) {
      std::vector<double> pattern;
      for (double part : shape) {
        pattern.push_back(part * dt);
      }
      e.push_back(run(vehicle(), 300.0, pattern));
    }
    for (std::size_t i = 1; i < e.size(); ++i) {
      const double position = std::log2(e[i - 1].position / e[i].position);
      const double velocity = std::log2(e[i - 1].velocity / e[i].velocity);
      const double attitude = std::log2(e[i - 1].attitude / e[i].attitude);
      CAPTURE(shape.size(), i, position, velocity, attitude, e[i].position, e[i].velocity, e[i].attitude);
      REQUIRE(std::abs(position - 3.0) < 0.3);
      REQUIRE(std::abs(velocity - 3.0) < 0.3);
      REQUIRE(std::abs(attitude - 3.0) < 0.3);
    }
  }
}

TEST_CASE("heave without rotation: position follows a force that changes within the sample",
          "[strapdown][mechanization]") {
  Trajectory t;
  t.lat.start = 37.0 * degree;
  t.lon.start = 127.0 * degree;
  t.height = {100.0, 0.0, {{2.0, 3.0, 0.0}}};  // 18 m/s²
  const Errors e = run(t, 60.0, {0.02});
  CAPTURE(e.position, e.velocity);
  REQUIRE(e.position < 1e-4);  // h² f/12 = 6e-4 m without the scrolling term, 1.2e-3 m with the wrong sign
}

TEST_CASE("a fast aircraft, far north and across the date line", "[strapdown][mechanization]") {
  const double metre = 1.0 / 6.37e6;
  Trajectory t = vehicle();
  t.lat.start = 75.0 * degree;
  t.lat.slope = 150.0 * metre;
  t.lon.start = 179.97 * degree;
  t.lon.slope = 260.0 * metre / std::cos(75.0 * degree);
  t.height.start = 9000.0;
  const Errors e = run(t, 120.0, {0.005});
  CAPTURE(e.position, e.velocity, e.attitude);
  REQUIRE(e.position < 1e-4);
  REQUIRE(e.velocity < 1e-5);
  REQUIRE(e.attitude < 1e-9);
}

TEST_CASE("ten minutes at rest", "[strapdown][mechanization]") {
  for (double lat : {-60.0 * degree, 0.0, 37.0 * degree}) {
    const Navigation start = at_rest(lat);
    const Increment increment = rest_increment(start, 0.005);
    Navigation nav = start;
    Previous previous;
    for (int i = 0; i < 120000; ++i) {
      nav = advance(nav, increment, previous);
      previous = remember(previous, increment);
    }
    const Errors e = compare(nav, start);
    CAPTURE(lat, e.position, e.velocity, e.attitude);
    // Rates that are constant in body axes are so only while the attitude is; 1e-5 m is what roundoff leaves.
    REQUIRE(e.position < 1e-5);
    REQUIRE(e.velocity < 1e-7);
    REQUIRE(e.attitude < 1e-10);
  }
}

TEST_CASE("a tilt swings with Schuler's period", "[strapdown][mechanization]") {
  const double tilt = 1e-5;
  const Navigation truth = at_rest(10.0 * degree);
  Navigation nav = truth;
  nav.q_nb = attitude_plus(truth.q_nb, Vector3d{0, -tilt, 0});  // truth = exp(+tilt about east) estimate
  const double dt = 0.1;
  const Increment increment = rest_increment(truth, dt);
  const double r = radii(truth.lla[0]).meridian + truth.lla[2], g = gravity(truth.lla[0], truth.lla[2]).down;
  const double period = 2.0 * pi * std::sqrt(r / g);  // 84 minutes
  std::vector<double> crossings;
  double largest = 0.0, before = 0.0;
  Previous previous;
  for (int i = 1; i * dt < 1.2 * period; ++i) {
    nav = advance(nav, increment, previous);
    previous = remember(previous, increment);
    if (i > 1 && before * nav.v_n[0] < 0.0) {
      crossings.push_back(i * dt);
    }
    largest = i * dt < period / 2 ? std::max(largest, nav.v_n[0]) : largest;
    before = nav.v_n[0];
  }
  CAPTURE(period, largest, crossings.size());
  REQUIRE(std::abs(period - 84.4 * 60.0) < 60.0);
  REQUIRE(std::abs(largest - tilt * std::sqrt(g * r)) < 0.02 * largest);  // north first: dv/dt = +g phi_E
  REQUIRE(crossings.size() == 2);
  REQUIRE(std::abs(crossings[0] - period / 2) < 0.02 * period);
  REQUIRE(std::abs(crossings[1] - period) < 0.02 * period);
}

TEST_CASE("constant rates are integrated exactly, large angles included", "[strapdown][mechanization]") {
  // At rest in space but for a fast spin and a body-fixed force: compare one long step with many short ones.
  Navigation nav = at_rest(0.6);
  for (double dt : {0.01, 0.1}) {
    const Increment whole{dt, Vector3d{9.0, -7.0, 5.0} * dt, Vector3d{3.0, 2.0, -9.0} * dt};
    const int parts = 1000;
    const std::vector<Increment> fine(parts, Increment{dt / parts, whole.dtheta / parts, whole.dv / parts});
    const Navigation one = advance(nav, whole), many = advance(nav, fine, {});
    const Errors e = compare(one, many);
    CAPTURE(dt, e.position, e.velocity, e.attitude);
    REQUIRE(e.position < 1e-7 + 1e-4 * std::pow(dt, 4));
    REQUIRE(e.velocity < 1e-12 + 1e-3 * std::pow(dt, 3));
    REQUIRE(e.attitude < 1e-13 + 1e-6 * std::pow(dt, 3));
  }
}

TEST_CASE("several increments are the fold of single ones", "[strapdown][mechanization]") {
  const Trajectory t = vehicle();
  std::vector<Increment> samples;
  double at = 3.0;
  for (double dt : {0.005, 0.002, 0.011, 0.004}) {
    samples.push_back(t.increment(at, at + dt));
    at += dt;
  }
  Navigation nav = t.at(3.0).nav;
  const Navigation start = nav;
  Previous previous = remember({}, t.increment(2.99, 3.0));
  const Navigation all = advance(start, samples, previous);
  for (const Increment& sample : samples) {
    nav = advance(nav, sample, previous);
    previous = remember(previous, sample);
  }
  REQUIRE(all.lla == nav.lla);
  REQUIRE(all.v_n == nav.v_n);
  REQUIRE(all.q_nb == nav.q_nb);
}

namespace {

/// Runs 20 s of the trajectory at 100 Hz; every third sample is cut after `part` of its length into proportional
/// fragments. `declared` is whether they say so.
Errors run_cut(const Trajectory& t, double part, bool declared) {
  const double dt = 0.01;
  Navigation nav = t.at(0.0).nav;
  Previous previous;
  for (int i = 0; i < 2000; ++i) {
    const Increment whole = t.increment(i * dt, (i + 1) * dt);
    std::vector<Increment> pieces{whole};
    if (part > 0.0 && i % 3 == 0) {
      const auto piece = [&](double share, double offset) {
        return Increment{share * dt, share * whole.dtheta, share * whole.dv, declared ? dt : 0.0,
                         declared ? offset * dt : 0.0};
      };
      pieces = {piece(part, 0.0), piece(1.0 - part, part)};
    }
    for (const Increment& p : pieces) {
      nav = advance(nav, p, previous);
      previous = remember(previous, p);
    }
  }
  return compare(nav, t.at(20.0).nav);
}

}  // namespace

TEST_CASE("a sample cut at a measurement's time leaves coning and sculling as they were",
          "[strapdown][mechanization]") {
  // A cone: roll and pitch a quarter period apart, at 3 Hz, and a vibration in step with it.
  Trajectory t = vehicle();
  t.roll.tones = {{2.0 * degree, 18.0, 0.0}};
  t.pitch.tones = {{2.0 * degree, 18.0, pi / 2}};
  t.height.tones = {{0.02, 18.0, 0.0}};
  const Errors uncut = run_cut(t, 0.0, true);
  for (double part : {0.5, 0.1, 1e-3, 0.999}) {
    const Errors cut = run_cut(t, part, true), blind = run_cut(t, part, false);
    CAPTURE(part, uncut.attitude, cut.attitude, blind.attitude, uncut.velocity, cut.velocity, blind.velocity);
    REQUIRE(cut.attitude < 1.2 * uncut.attitude);
    REQUIRE(cut.velocity < 1.2 * uncut.velocity);
    REQUIRE(cut.position < 1.2 * uncut.position + 1e-6);
    // A fragment taken for a sample spoils them: the test is able to fail.
    REQUIRE(blind.attitude > 2.0 * uncut.attitude);
  }
}

TEST_CASE("what the mechanization remembers", "[strapdown][mechanization]") {
  const Increment first{0.01, Vector3d{1, 2, 3}, Vector3d{4, 5, 6}};
  const Increment half{0.004, Vector3d{2, 0, 0}, Vector3d{0, 2, 0}, 0.008, 0.0};
  const Increment rest{0.004, Vector3d{2, 0, 0}, Vector3d{0, 2, 0}, 0.008, 0.004};
  const Previous a = remember({}, first);
  REQUIRE(a.before.dt == 0.0);
  REQUIRE(a.last.dt == 0.01);
  REQUIRE((a.last.omega - Vector3d{100, 200, 300}).norm() < 1e-12);
  const Previous b = remember(a, half), c = remember(b, rest);
  REQUIRE(b.last.dt == 0.008);
  REQUIRE(c.last.dt == 0.008);
  REQUIRE((c.last.omega - Vector3d{500, 0, 0}).norm() < 1e-12);
  REQUIRE((c.last.f - Vector3d{0, 500, 0}).norm() < 1e-12);
  REQUIRE(b.before.omega == a.last.omega);
  REQUIRE(c.before.omega == a.last.omega);
}

}  // namespace strapdown_mechanization_test
