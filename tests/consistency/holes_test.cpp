// SPDX-License-Identifier: Apache-2.0
// After a hole in the inertial input the covariance is what the vehicle may have done meanwhile: NEES right after the
// bridged step and after the first fixes, and the share of fixes refused, over Monte Carlo runs whose motion fills
// `bridge`.
//
// The vehicle goes round a bend. In the hole it adds an acceleration over ground and an angular rate, each constant and
// drawn per axis with the standard deviation that `bridge` states. A constant has one degree of freedom per axis, where
// the white noise that stands for it has two, in velocity and position: so NEES may fall short of its 9, to a third.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>

#include "binnacle/eigen.hpp"
#include "binnacle/session.hpp"
#include "binnacle/state_block.hpp"
#include "catch.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/mechanization.hpp"
#include "strapdown/rotation.hpp"

namespace holes_test {

using namespace binnacle;

namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using strapdown::quaternion_product;

constexpr int runs = 200;
constexpr double confidence = 0.99;
constexpr double degree = M_PI / 180;

// As holes.json has them.
constexpr double gate = 0.99;
constexpr double gyro_noise = 0.1 * degree / 60, accel_noise = 0.03 / 60;  // rad/√s, m/s/√s
constexpr double first_position = 2, first_velocity = 0.2, first_attitude = 1 * degree;
constexpr double fix_position = 0.3, fix_velocity = 0.1;

constexpr double input_interval = 0.1, fix_interval = 0.5;  // s
constexpr double before = 20, after = 10;                   // s, of the hole

struct Hole {
  double length;        // s
  double acceleration;  // m/s²
  Vector3d rate;        // deg/s, in body axes
  bool has_fixes;       // it is one of the inertial sensor alone
};
struct Setting {
  std::string model;
  bool increments = true;    // the channel has them, else rates
  double bridge_factor = 1;  // on what the vehicle does: what `bridge` states that it may do
};

std::string per_axis(const Vector3d& rate) {
  std::string list;
  for (const double r : rate) list += (list.empty() ? "[\"" : ", \"") + std::to_string(r) + " deg/s\"";
  return list + "]";
}

std::shared_ptr<const Composition> composition(const Hole& hole, const Setting& setting) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  const std::string strapdown = "/filters/ins/process/strapdown/";
  LoadOptions options;
  options.sets = {strapdown + "type=" + setting.model,
                  strapdown + "bridge/acceleration=" + std::to_string(hole.acceleration * setting.bridge_factor),
                  strapdown + "bridge/rate=" + per_axis(hole.rate * setting.bridge_factor)};
  for (const char* axis : {"x", "y", "z"}) {
    if (setting.increments) break;
    const std::string field = "/sources/imu/fields/";
    options.sets.push_back(field + "w" + axis + R"(={"unit": "rad/s", "kind": "rate"})");
    options.sets.push_back(field + "f" + axis + R"(={"unit": "m/s^2", "kind": "rate"})");
  }
  return Composition::load(BINNACLE_TEST_PROJECT "/tests/consistency/holes.json", options);
}

class Normal {
 public:
  explicit Normal(unsigned seed) : engine_(seed) {}
  Vector3d operator()(double sigma) { return (*this)(Vector3d::Constant(sigma)); }
  Vector3d operator()(const Vector3d& sigma) {
    const Vector3d drawn = Vector3d::NullaryExpr([&](Eigen::Index) { return normal_(engine_); });
    return sigma.cwiseProduct(drawn);
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

/// A vehicle that goes round a bend, and what it does besides.
class Vehicle {
 public:
  explicit Vehicle(const strapdown::Navigation& start) : nav_(start) { steer({}, {}); }

  const strapdown::Navigation& nav() const { return nav_; }

  /// From now on, besides the bend: an acceleration over ground, north, east, down, and a rate in body axes.
  void steer(const Vector3d& acceleration, const Vector3d& rate) {
    acceleration_ = acceleration, rate_ = rate;
    q_bend_ = nav_.q_nb;
  }

  /// Goes on for h: what an ideal sensor measures of it.
  strapdown::Increment advance(double h) {
    const Vector4d half_bend = strapdown::quaternion_exp(0.5 * h * bend);
    q_bend_ = quaternion_product(q_bend_, half_bend);
    const Vector3d a_n = acceleration_ + strapdown::dcm_from_quaternion(q_bend_) * Vector3d{0, speed * bend[2], 0};
    q_bend_ = quaternion_product(q_bend_, half_bend);

    const double sin_lat = std::sin(nav_.lla[0]), cos_lat = std::cos(nav_.lla[0]);
    const strapdown::Radii radii = strapdown::radii(sin_lat, cos_lat);
    const double east = nav_.v_n[1] / (radii.transverse + nav_.lla[2]);
    const Vector3d ie = strapdown::wgs84::omega_ie * Vector3d{cos_lat, 0, -sin_lat};
    const Vector3d en{east, -nav_.v_n[0] / (radii.meridian + nav_.lla[2]), -east * sin_lat / cos_lat};
    const Vector3d g_n{0, 0, strapdown::gravity(nav_.lla[0], nav_.lla[2]).down};
    const Vector4d middle = quaternion_product(nav_.q_nb, strapdown::quaternion_exp(0.5 * h * (bend + rate_)));
    const Eigen::Matrix3d C_bn = strapdown::dcm_from_quaternion(middle).transpose();

    strapdown::Increment increment;
    increment.dt = h;
    increment.dtheta = h * (bend + rate_ + C_bn * (ie + en));
    increment.dv = h * C_bn * (a_n - g_n + (2 * ie + en).cross(nav_.v_n));
    nav_ = strapdown::advance(nav_, {&increment, 1}, {});
    return increment;
  }

 private:
  static constexpr double speed = 10;                   // m/s
  static inline const Vector3d bend{0, 0, 3 * degree};  // rad/s
  strapdown::Navigation nav_;
  Vector3d acceleration_, rate_;
  Vector4d q_bend_;  // attitude without that rate: along it the bend accelerates
};

struct Figures {
  double nees_after_hole = 0, nees_after_fixes = 0;  // mean; the latter 1 s after the first fix
  std::int64_t fixes = 0, refused = 0;               // after the hole
};

class Simulation {
 public:
  Simulation(const Hole& hole, const Setting& setting)
      : hole_(hole), increments_(setting.increments), session_(composition(hole, setting)) {}

  Figures figures() {
    Figures figures;
    for (unsigned run = 0; run < runs; ++run) add(run, figures);
    return figures;
  }

 private:
  const FilterInfo& filter() const { return session_.composition().filters()[0]; }
  std::int64_t count(Outcome outcome) const {
    return session_.counts(fix_).by_outcome[static_cast<std::size_t>(outcome)];
  }

  void add(unsigned seed, Figures& figures) {
    session_.reset();
    Normal normal(seed);
    Vehicle vehicle = start(normal);
    drive(vehicle, before, normal, true, true);
    const Vector3d acceleration = normal(hole_.acceleration);
    vehicle.steer(acceleration, normal(Vector3d(hole_.rate * degree)));
    drive(vehicle, before + hole_.length, normal, false, hole_.has_fixes);
    vehicle.steer(Vector3d::Zero(), Vector3d::Zero());

    drive(vehicle, t_ + input_interval, normal, true, true);  // the first sample brings the bridge about
    figures.nees_after_hole += nees(vehicle) / runs;
    const std::int64_t accepted = count(Outcome::accepted), gated = count(Outcome::gated);
    drive(vehicle, next_fix_ + 1.05, normal, true, true);
    figures.nees_after_fixes += nees(vehicle) / runs;
    drive(vehicle, before + hole_.length + after, normal, true, true);
    figures.refused += count(Outcome::gated) - gated;
    figures.fixes += count(Outcome::gated) - gated + count(Outcome::accepted) - accepted;
  }

  Vehicle start(Normal& normal) {
    t_ = 0, next_fix_ = 0.25;
    const auto& blocks = filter().blocks;
    strapdown::Navigation nav;
    nav.lla = moved(Eigen::Map<const Vector3d>(blocks[0].initial.data()), normal(first_position));
    nav.v_n = Eigen::Map<const Vector3d>(blocks[1].initial.data()) + normal(first_velocity);
    nav.q_nb = quaternion_product(strapdown::quaternion_exp(normal(first_attitude)),
                                  Eigen::Map<const Vector4d>(blocks[2].initial.data()));
    Vehicle vehicle(nav);
    vehicle.steer(Vector3d::Zero(), Vector3d::Zero());
    return vehicle;
  }

  /// Until a time; inertial samples end at multiples of their interval, and where a fix comes.
  void drive(Vehicle& vehicle, double until, Normal& normal, bool has_input, bool has_fixes) {
    while (t_ < until - 1e-6) {
      const double t0 = t_, sample_end = (std::floor(t_ / input_interval + 1e-6) + 1) * input_interval;
      t_ = std::min({until, next_fix_, sample_end});
      const double h = t_ - t0;
      const strapdown::Increment increment = vehicle.advance(h);
      const double per = increments_ ? 1 : 1 / h;
      Eigen::Matrix<double, 6, 1> fields;
      fields << per * (increment.dtheta + normal(gyro_noise * std::sqrt(h))),
          per * (increment.dv + normal(accel_noise * std::sqrt(h)));
      if (has_input) session_.push(imu_, nanoseconds(t0), nanoseconds(t_), {fields.data(), 6});
      if (t_ < next_fix_ - 1e-6) continue;
      fields << moved(vehicle.nav().lla, normal(fix_position)), vehicle.nav().v_n + normal(fix_velocity);
      if (has_fixes) session_.push(gnss_, no_time, nanoseconds(t_), {fields.data(), 6});
      next_fix_ += fix_interval;
    }
  }

  Vector3d moved(const Vector3d& lla, const Vector3d& by) const {
    Vector3d to;
    filter().blocks[0].block->plus({lla.data(), 3}, {by.data(), 3}, {to.data(), 3});
    return to;
  }

  double nees(const Vehicle& vehicle) const {
    REQUIRE(session_.healthy({0}));
    REQUIRE(session_.time({0}) == nanoseconds(t_));
    const auto& nav = vehicle.nav();
    const std::array<std::span<const double>, 3> truth{
        {{nav.lla.data(), 3}, {nav.v_n.data(), 3}, {nav.q_nb.data(), 4}}};
    Eigen::Matrix<double, 9, 1> delta;
    for (std::size_t b = 0; b < truth.size(); ++b) {
      const BlockInfo& block = filter().blocks[b];
      const auto estimate = session_.state({0}).subspan(static_cast<std::size_t>(block.stored_offset), truth[b].size());
      block.block->minus(truth[b], estimate, {delta.data() + block.first_row, 3});
    }
    const Eigen::MatrixXd P = session_.covariance(FilterId{0}).as();
    const Eigen::LLT<Eigen::MatrixXd> factor(P);
    REQUIRE(factor.info() == Eigen::Success);
    return delta.dot(factor.solve(delta));
  }

  Hole hole_;
  bool increments_;
  Session session_;
  ChannelId imu_ = session_.channel("imu"), gnss_ = session_.channel("gnss");
  MeasurementId fix_ = session_.measurement("fix");
  double t_ = 0, next_fix_ = 0;
};

constexpr double least_nees = 9.0 / 3;

double most_nees() {
  return boost::math::quantile(complement(boost::math::chi_squared(9.0 * runs), 1 - confidence)) / runs;
}
double most_refused(const Figures& found) {
  const boost::math::binomial refused(static_cast<double>(found.fixes), 1 - gate);
  return boost::math::quantile(complement(refused, 1 - confidence));
}

Figures monte_carlo(const Hole& hole, const Setting& setting) {
  const Figures found = Simulation(hole, setting).figures();
  std::printf("%s, %s, %4.1f s %s fixes, %s, x %.1f: NEES %.2f, %.2f (%.0f … %.2f), refused %lld of %lld (%.0f)\n",
              setting.model.c_str(), setting.increments ? "increments" : "rates", hole.length,
              hole.has_fixes ? "with" : "without", per_axis(hole.rate).c_str(), setting.bridge_factor,
              found.nees_after_hole, found.nees_after_fixes, least_nees, most_nees(),
              static_cast<long long>(found.refused), static_cast<long long>(found.fixes), most_refused(found));
  return found;
}

const std::vector<std::string> models = {"phi_error", "psi_error"};
const Vector3d upright(1, 1, 5);  // a vehicle that turns more than it tilts [deg/s]
const Vector3d tumbling(5, 5, 5);

}  // namespace

// Within 2.5 deg of tilt and 10 deg of heading (1-sigma): see the next test.
TEST_CASE("after a hole NEES and the share of fixes refused are those of a right filter") {
  for (const std::string& model : models)
    for (const bool has_fixes : {false, true})
      for (const Hole& hole :
           {Hole{0.5, 1, tumbling, has_fixes}, Hole{2, 1, upright, has_fixes}, Hole{10, 1, {0.2, 0.2, 1}, has_fixes}}) {
        CAPTURE(model, has_fixes, hole.length);
        const Figures found = monte_carlo(hole, {model});
        CHECK(found.nees_after_hole < most_nees());
        CHECK(found.nees_after_hole > least_nees);
        CHECK(found.nees_after_fixes < most_nees());
        CHECK(found.nees_after_fixes > least_nees);
        CHECK(static_cast<double>(found.refused) <= most_refused(found));
      }
}

// By up to 50 deg per axis. The first fixes are then refused too often, and NEES after them is not right. No noise of
// the bridge changes that: the filter is linear, and a tilt φ is also an error of φ² g/2 in the vertical acceleration.
TEST_CASE("after a hole in which the vehicle may have turned far NEES is that of a right filter") {
  for (const std::string& model : models)
    for (const bool has_fixes : {false, true})
      for (const double length : {2.0, 10.0}) {
        CAPTURE(model, has_fixes, length);
        const Figures found = monte_carlo({length, 1, tumbling, has_fixes}, {model});
        CHECK(found.nees_after_hole < most_nees());
        CHECK(found.nees_after_hole > least_nees);
      }
}

// The specific force held is then that after the hole, with gravity where the vehicle's turn has brought it.
TEST_CASE("after a hole in a channel of rates NEES is that of a right filter") {
  for (const std::string& model : models)
    for (const bool has_fixes : {false, true})
      for (const double length : {0.5, 2.0}) {
        CAPTURE(model, has_fixes, length);
        const Figures found = monte_carlo({length, 1, tumbling, has_fixes}, {model, false});
        CHECK(found.nees_after_hole < most_nees());
        CHECK(found.nees_after_hole > least_nees);
      }
}

TEST_CASE("half and twice the bridge's noise are found out") {
  for (const std::string& model : models)
    for (const Hole& hole :
         {Hole{0.5, 1, tumbling, false}, Hole{2, 1, upright, false}, Hole{10, 1, {0.2, 0.2, 1}, false}}) {
      CAPTURE(model, hole.length);
      const Figures half = monte_carlo(hole, {model, true, 0.5});
      CHECK(half.nees_after_hole > most_nees());
      CHECK(half.nees_after_fixes > most_nees());
      CHECK(static_cast<double>(half.refused) > most_refused(half));
      CHECK(monte_carlo(hole, {model, true, 2}).nees_after_hole < least_nees);
    }
}

}  // namespace holes_test
