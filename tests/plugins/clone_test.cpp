// SPDX-License-Identifier: Apache-2.0
// Plugin clone: when a copy is made and what Φ says of it; the displacement, its Jacobians and refusals; simulated ones.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "../../plugins/clone/clone.hpp"
#include "../../plugins/clone/displacement.hpp"
#include "../../plugins/clone/relative_position.hpp"

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "strapdown/earth.hpp"
#include "strapdown/rotation.hpp"
#include "support/navigation_kinds.hpp"

namespace clone_test {

using namespace binnacle;
using namespace binnacle::clone;
using namespace binnacle::test;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

bool says(const std::string& message, const std::string& part) {
  UNSCOPED_INFO(message);
  return message.find(part) != std::string::npos;
}

Step step_of(double from, double to) {
  Step step;
  step.t0 = nanoseconds(from);
  step.t1 = nanoseconds(to);
  step.dt = to - from;
  return step;
}

/// A vector of two that is copied, and its age.
struct Bench {
  explicit Bench(nlohmann::json parameters = nlohmann::json::object(), bool has_channel = true)
      : model(bind<Clone>({std::move(parameters),
                           {{"of", &of}, {"copy", &copy}, {"age", &age}},
                           has_channel ? std::vector<std::string>{} : std::vector<std::string>{"at"}})),
        memory(caller().fresh_memory()) {}

  testing::ProcessCaller caller() const { return {*model, spec, std::span(&sample, 1)}; }
  /// With x as it is given; the copy goes on.
  bool copies(double from, double to, std::vector<double> x) {
    ports[0].x = x;
    const std::vector<double> before = ports[1].x;
    const auto p = caller().propagate(ports, step_of(from, to), memory);
    REQUIRE(p.result);
    REQUIRE(p.damage == "");
    REQUIRE_NO_COMPLAINTS(check_values(caller(), ports, step_of(from, to), memory));
    REQUIRE_NO_COMPLAINTS(check_transition(caller(), ports, step_of(from, to), memory, {1e-9}));
    REQUIRE(caller().Q(ports, p).isZero(0));
    memory = p.memory;
    const bool is_copy = p.x_plus[1] == x;
    REQUIRE((is_copy || p.x_plus[1] == before));
    const Eigen::MatrixXd Phi = caller().Phi(ports, p);
    REQUIRE(Phi.block(2, 0, 2, 2) == (is_copy ? 1.0 : 0.0) * Eigen::Matrix2d::Identity());
    REQUIRE(Phi.block(2, 2, 2, 2) == (is_copy ? 0.0 : 1.0) * Eigen::Matrix2d::Identity());
    ports = caller().after(ports, p);
    return is_copy;
  }
  void emit(double t, double t0 = -1) {
    sample.available = true;
    sample.t = nanoseconds(t);
    sample.t0 = t0 < 0 ? no_time : nanoseconds(t0);
  }

  AdditiveKind of{2, "m"}, copy{2, "m"}, age{1, "s"};
  ComponentSpec spec = Clone::spec();
  std::unique_ptr<Clone> model;
  SampleView sample;
  std::vector<std::byte> memory;
  PortStates ports{{&of, {0, 0}}, {&copy, {-1, -1}}, {}, {}, {}, {}, {&age, {0}}};
};

}  // namespace

TEST_CASE("clone: the first step copies, and then the first that begins when a sample came, or later", "[clone]") {
  Bench bench;
  CHECK(bench.copies(5, 5.1, {1, 2}));
  CHECK(bench.ports[6].x[0] == 0.1);
  CHECK_FALSE(bench.copies(5.1, 5.2, {2, 3}));
  bench.emit(5.35);  // ahead of the filter
  CHECK_FALSE(bench.copies(5.2, 5.3, {3, 4}));
  CHECK_FALSE(bench.copies(5.3, 5.35, {4, 5}));
  CHECK(std::abs(bench.ports[6].x[0] - 0.35) < 1e-15);
  CHECK(bench.copies(5.35, 5.4, {5, 6}));
  CHECK(bench.ports[6].x[0] == 0.05);
  CHECK_FALSE(bench.copies(5.4, 5.5, {6, 7}));
  bench.emit(5.45);  // between two steps: the next one's begin is the instant
  CHECK(bench.copies(5.5, 5.6, {7, 8}));
  CHECK(bench.ports[6].x[0] == 0.1);
  CHECK_FALSE(bench.copies(5.6, 5.7, {8, 9}));
}

TEST_CASE("clone: a step that is taken when the next sample has come copies at the time of the one before", "[clone]") {
  // As filters without a driving input do: they step from sample to sample.
  Bench bench;
  bench.emit(1);
  CHECK(bench.copies(0, 1, {1, 1}));
  for (int k = 2; k < 8; ++k) {
    bench.emit(k);
    CHECK(bench.copies(k - 1, k, {1.0 * k, 2}));
    CHECK(bench.ports[6].x[0] == 1);
  }
}

TEST_CASE("clone: samples ahead of the filter wait, and of one that was not seen the next one has the time",
          "[clone]") {
  Bench bench;
  CHECK(bench.copies(0, 0.1, {1, 1}));
  bench.emit(0.3);
  CHECK_FALSE(bench.copies(0.1, 0.2, {2, 2}));
  bench.emit(0.5);
  CHECK_FALSE(bench.copies(0.2, 0.3, {3, 3}));
  CHECK(bench.copies(0.3, 0.4, {4, 4}));
  bench.emit(0.9, 0.7);  // that of 0.7 came between two calls
  CHECK_FALSE(bench.copies(0.4, 0.5, {5, 5}));
  CHECK(bench.copies(0.5, 0.6, {6, 6}));
  CHECK_FALSE(bench.copies(0.6, 0.7, {7, 7}));
  CHECK(bench.copies(0.7, 0.8, {8, 8}));
  CHECK_FALSE(bench.copies(0.8, 0.9, {9, 9}));
  CHECK(bench.copies(0.9, 1.0, {10, 10}));
}

TEST_CASE("clone: the begin of the newest sample's interval is an instant to be kept, when a step begins there",
          "[clone]") {
  Bench bench;
  CHECK(bench.copies(0, 0.1, {1, 1}));
  bench.emit(0.3, 0.1);
  CHECK(bench.copies(0.1, 0.2, {2, 2}));
  CHECK_FALSE(bench.copies(0.2, 0.3, {3, 3}));
}

TEST_CASE("clone: asked twice in a step it answers the same", "[clone]") {
  // Who propagates sigma points calls it once for each.
  Bench bench;
  for (const double x : {1.0, 2.0, 3.0}) CHECK(bench.copies(0, 0.1, {x, x}));
  bench.emit(0.1);
  for (const double x : {4.0, 5.0, 6.0}) CHECK(bench.copies(0.1, 0.2, {x, x}));
  for (const double x : {7.0, 8.0, 9.0}) CHECK_FALSE(bench.copies(0.2, 0.3, {x, x}));
}

TEST_CASE("clone: by time, and at rest", "[clone]") {
  Bench bench({{"every", 0.25}}, false);
  std::vector<double> when;
  for (int k = 0; k < 12; ++k)
    if (bench.copies(0.1 * k, 0.1 * (k + 1), {1.0 * k, 0})) when.push_back(k);
  CHECK(when == std::vector<double>{0, 3, 6, 9});
  // A step of no length is none, also where one would copy.
  const auto caller = bench.caller();
  const int n = testing::offset(bench.ports, bench.ports.size());
  REQUIRE_NO_COMPLAINTS(check_rest(caller, bench.ports, step_of(5, 5), bench.memory, Eigen::MatrixXd::Zero(n, n), 0.0));
  REQUIRE_NO_COMPLAINTS(
      check_rest(caller, bench.ports, step_of(5, 5), caller.fresh_memory(), Eigen::MatrixXd::Zero(n, n), 0.0));
}

TEST_CASE("clone: more samples ahead than there is room for", "[clone]") {
  Bench bench;
  CHECK(bench.copies(0, 0.001, {1, 1}));
  for (int k = 1; k < 80; ++k) {
    bench.emit(1 + k);
    CHECK_FALSE(bench.copies(0.001 * k, 0.001 * (k + 1), {2, 2}));
  }
  CHECK(bench.copies(2, 2.1, {3, 3}));
  CHECK(bench.copies(65, 65.1, {4, 4}));        // the last that was kept
  CHECK_FALSE(bench.copies(70, 70.1, {5, 5}));  // not kept
}

TEST_CASE("clone: what does not fit is refused", "[clone]") {
  const AdditiveKind two(2, "m"), three(3, "m");
  const auto message = [](const Setup& setup) {
    try {
      bind<Clone>(setup);
    } catch (const ComponentError& error) {
      return error.pointer() + ": " + error.what();
    }
    return std::string();
  };
  CHECK(says(message({{}, {{"of", &two}, {"copy", &three}}, {}}),
             "/blocks/copy: a copy has the kind of what it copies: 'of' is of the kind 'vector:2:m', 'copy' "
             "of the kind 'vector:3:m'"));
  CHECK(says(message({{}, {{"of", &two}, {"copy", &two}, {"of_2", &two}}, {}}),
             "/blocks: 'of_2' and 'copy_2' need each other"));
  CHECK(says(message({{}, {{"of", &two}, {"copy", &two}}, {"at"}}), "nothing specifies when to copy"));
}

// ---- the displacement

namespace {

struct Place {
  Vector3d lla;
  Vector3d euler;
};

std::vector<double> numbers(const Eigen::VectorXd& v) { return {v.data(), v.data() + v.size()}; }

struct Way {
  AdditiveKind age{1, "s"}, local{3, "m"};
  PositionKind geodetic;
  AttitudeKind attitude;

  /// From a place with everything askew, by metres north, east, down as the tangent there has them.
  PortStates geodetic_ports(double lat, const Vector3d& by, bool has_attitude) const {
    const Vector3d then(lat, 2.1, 300);
    const Vector3d now = strapdown::position_plus(then, by);
    PortStates ports{{&geodetic, numbers(now), 1.0, 1e-8},
                     {&geodetic, numbers(then), 1.0, 1e-8},
                     {},
                     {&age, {0.5}, 1e-8}};
    if (has_attitude) ports[2] = {&attitude, numbers(strapdown::quaternion_from_euler({0.3, -0.2, -0.5})), 1e-2, 4e-16};
    return ports;
  }
};

SampleView displacement(const std::vector<double>& fields, double t = 2.5, double t0 = 2.0) {
  SampleView sample;
  sample.t = nanoseconds(t);
  sample.t0 = nanoseconds(t0);
  sample.fields = fields.data();
  return sample;
}

const std::vector<std::string> no_sd{"dx_sd", "dy_sd", "dz_sd"};

}  // namespace

TEST_CASE("relative position: residual and H of a geodetic position, in both axes", "[clone]") {
  const Way bench;
  const Vector3d by(40, -25, 3);
  for (const double lat : {0.0, 0.85, -1.35}) {
    CAPTURE(lat);
    for (const bool is_body : {true, false}) {
      Ports plugged{{"position", &bench.geodetic}, {"copy", &bench.geodetic}, {"age", &bench.age}};
      if (is_body) plugged["attitude"] = &bench.attitude;
      const auto model =
          bind<RelativePosition>({{{"sigma", 0.1}, {"frame", is_body ? "body" : "navigation"}}, plugged, no_sd});
      const PortStates ports = bench.geodetic_ports(lat, by, is_body);
      // Of the way itself, by the ellipsoid: r_e in the axes of the begin.
      const Vector3d then = Eigen::Map<const Vector3d>(ports[1].x.data()),
                     now = Eigen::Map<const Vector3d>(ports[0].x.data());
      Vector3d d = strapdown::C_en(then[0], then[1]).transpose() *
                   (strapdown::ecef_from_lla(now) - strapdown::ecef_from_lla(then));
      CHECK((d - by).norm() < 1e-3);  // 47 m are 0.2 mm below the tangent
      if (is_body)
        d = strapdown::dcm_from_quaternion(Eigen::Map<const Eigen::Vector4d>(ports[2].x.data())).transpose() * d;
      const std::vector<double> z = {d[0] + 0.3, d[1] - 0.2, d[2] + 0.1, 0, 0, 0};
      Complaints out;
      const Measured m = linearize(*model, displacement(z), ports, {}, out);
      REQUIRE_NO_COMPLAINTS(out);
      CHECK((m.residual - Vector3d(0.3, -0.2, 0.1)).norm() < 1e-8);
      CHECK(m.R.isApprox(0.01 * Matrix3d::Identity()));
      REQUIRE_NO_COMPLAINTS(
          check_measurement(*model, RelativePosition::spec(), displacement(z), ports, {}, {2e-7}, 1e-8));
    }
  }
}

TEST_CASE("relative position: of geodetic and ECEF positions, in the axes of body, navigation and earth", "[clone]") {
  const Way bench;
  const AdditiveKind ecef("position.ecef", 3, "m");
  const Vector3d by(400, -250, 30);
  for (const double lat : {0.0, 0.85, -1.35})
    for (const std::string frame : {"body", "navigation", "ecef"}) {
      CAPTURE(lat, frame);
      const bool is_body = frame == "body";
      const PortStates geodetic = bench.geodetic_ports(lat, by, is_body);
      const Vector3d then = Eigen::Map<const Vector3d>(geodetic[1].x.data()),
                     now = Eigen::Map<const Vector3d>(geodetic[0].x.data());
      const Vector3d r_then = strapdown::ecef_from_lla(then), r_now = strapdown::ecef_from_lla(now);
      PortStates in_ecef = geodetic;
      in_ecef[0] = {&ecef, numbers(r_now), 1.0, 1e-8};
      in_ecef[1] = {&ecef, numbers(r_then), 1.0, 1e-8};
      Vector3d d = r_now - r_then;
      if (frame != "ecef") d = strapdown::C_en(then[0], then[1]).transpose() * d;
      if (is_body)
        d = strapdown::dcm_from_quaternion(Eigen::Map<const Eigen::Vector4d>(geodetic[2].x.data())).transpose() * d;
      const std::vector<double> z = {d[0] + 0.3, d[1] - 0.2, d[2] + 0.1, 0, 0, 0};
      for (const bool is_ecef : {false, true}) {
        const StateBlock& block = is_ecef ? static_cast<const StateBlock&>(ecef) : bench.geodetic;
        Ports plugged{{"position", &block}, {"copy", &block}, {"age", &bench.age}};
        if (is_body) plugged["attitude"] = &bench.attitude;
        const auto model = bind<RelativePosition>({{{"sigma", 0.1}, {"frame", frame}}, plugged, no_sd});
        const PortStates& ports = is_ecef ? in_ecef : geodetic;
        Complaints out;
        const Measured m = linearize(*model, displacement(z), ports, {}, out);
        REQUIRE_NO_COMPLAINTS(out);
        CHECK((m.residual - Vector3d(0.3, -0.2, 0.1)).norm() < 1e-8);
        REQUIRE_NO_COMPLAINTS(
            check_measurement(*model, RelativePosition::spec(), displacement(z), ports, {}, {2e-7}, 1e-8));
      }
    }
}

TEST_CASE("relative position: of a place 10 km away the turn of north, east, down is in H", "[clone]") {
  const Way bench;
  const auto model =
      bind<RelativePosition>({{{"sigma", 0.1}, {"frame", "navigation"}},
                              {{"position", &bench.geodetic}, {"copy", &bench.geodetic}, {"age", &bench.age}},
                              no_sd});
  const PortStates ports = bench.geodetic_ports(0.85, {8000, 6000, 0}, false);
  const std::vector<double> z = {8000, 6000, 0, 0, 0, 0};
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, RelativePosition::spec(), displacement(z), ports, {}, {2e-7}, 1e-8));
  Complaints out;
  const Measured m = linearize(*model, displacement(z), ports, {}, out);
  CHECK((m.H[0] - Matrix3d::Identity()).norm() > 1e-3);  // nor is it the identity
  CHECK((m.H[1] + Matrix3d::Identity()).norm() > 1e-3);
}

TEST_CASE("relative position: of a local position, of three components or fewer", "[clone]") {
  const Way bench;
  const AdditiveKind plane(2, "m");
  const auto model = bind<RelativePosition>(
      {{{"sigma", 0.1}},
       {{"position", &bench.local}, {"copy", &bench.local}, {"attitude", &bench.attitude}, {"age", &bench.age}},
       no_sd});
  const Eigen::Vector4d q = strapdown::quaternion_from_euler({0.3, -0.2, -0.5});
  const PortStates ports{{&bench.local, {10, 20, 30}},
                         {&bench.local, {7, 22, 29}},
                         {&bench.attitude, numbers(q), 1e-2, 4e-16},
                         {&bench.age, {0.5}, 1e-8}};
  const Vector3d d = strapdown::dcm_from_quaternion(q).transpose() * Vector3d(3, -2, 1);
  const std::vector<double> z = {d[0], d[1], d[2], 0, 0, 0};
  Complaints out;
  CHECK(linearize(*model, displacement(z), ports, {}, out).residual.norm() < 1e-14);
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, RelativePosition::spec(), displacement(z), ports, {}, {1e-8}));

  const auto flat = bind<RelativePosition>(
      {{{"frame", "navigation"}}, {{"position", &plane}, {"copy", &plane}, {"age", &bench.age}}, {"dz", "dz_sd"}});
  const std::vector<double> of_plane = {3.5, -2, 0, 0.2, 0.3, 0};
  const PortStates at{{&plane, {10, 20}}, {&plane, {7, 22}}, {}, {&bench.age, {0.5}, 1e-8}};
  const Measured m = linearize(*flat, displacement(of_plane), at, {}, out);
  CHECK(m.residual == Eigen::Vector2d(0.5, 0));
  CHECK(m.R.isApprox(Eigen::Vector2d(0.04, 0.09).asDiagonal().toDenseMatrix()));
  CHECK(m.H[0] == Eigen::Matrix2d::Identity());
  CHECK(m.H[1] == -Eigen::Matrix2d::Identity());
  REQUIRE_NO_COMPLAINTS(out);
}

TEST_CASE("relative position: noise grows with the way", "[clone]") {
  const Way bench;
  const auto model = bind<RelativePosition>({{{"sigma", 0.1}, {"relative", 0.01}, {"frame", "navigation"}},
                                             {{"position", &bench.local}, {"copy", &bench.local}, {"age", &bench.age}},
                                             no_sd});
  const PortStates ports{{&bench.local, {3, 4, 0}}, {&bench.local, {0, 0, 0}}, {}, {&bench.age, {0.5}, 1e-8}};
  Complaints out;
  const Measured m = linearize(*model, displacement({3, 4, 0, 0, 0, 0}), ports, {}, out);
  CHECK(m.R.isApprox((0.01 + 0.0025) * Matrix3d::Identity()));
}

TEST_CASE("relative position: what it refuses", "[clone]") {
  const Way bench;
  const auto model = bind<RelativePosition>(
      {{{"frame", "navigation"}}, {{"position", &bench.local}, {"copy", &bench.local}, {"age", &bench.age}}, {}});
  PortStates ports{{&bench.local, {3, 4, 0}}, {&bench.local, {0, 0, 0}}, {}, {&bench.age, {0.5}, 1e-8}};
  const auto result = [&](const SampleView& sample) {
    Complaints out;
    return linearize(*model, sample, ports, {}, out).result;
  };
  const std::vector<double> z = {3, 4, 0, 0.1, 0.1, 0.1};
  CHECK(result(displacement(z)));
  // The copy is of 2.0 s.
  CHECK(result(displacement(z, 2.5, 2.0)).refusal == Refusal::none);
  CHECK(result(displacement(z, 2.5, 1.9)).refusal == Refusal::unsupported);
  CHECK(result(displacement(z, 2.5, 2.000002)).refusal == Refusal::unsupported);
  CHECK(result(displacement(z, 2.5, 2.0000005)));
  ports[3].x[0] = NAN;
  CHECK(result(displacement(z)).refusal == Refusal::unsupported);
  ports[3].x[0] = 0.5;
  SampleView instant = displacement(z);
  instant.t0 = no_time;
  CHECK(result(instant).refusal == Refusal::invalid);
  CHECK(result(displacement({3, INFINITY, 0, 0.1, 0.1, 0.1})).refusal == Refusal::invalid);
  CHECK(result(displacement({3, 4, 0, 0.1, 0, 0.1})).refusal == Refusal::invalid);
  CHECK(result(displacement({3, 4, 0, 0.1, NAN, 0.1})).refusal == Refusal::invalid);
}

TEST_CASE("relative position: what does not fit is refused when it is bound", "[clone]") {
  const Way bench;
  const AdditiveKind ecef("position.ecef", 3, "m"), plane(2, "m");
  const auto message = [](const Setup& setup) {
    try {
      bind<RelativePosition>(setup);
    } catch (const ComponentError& error) {
      return error.pointer() + ": " + error.what();
    }
    return std::string();
  };
  const nlohmann::json navigation{{"frame", "navigation"}, {"sigma", 1}}, body{{"sigma", 1}};
  const auto with = [&](const StateBlock& position, const StateBlock& copy, bool has_attitude) {
    Ports ports{{"position", &position}, {"copy", &copy}, {"age", &bench.age}};
    if (has_attitude) ports["attitude"] = &bench.attitude;
    return ports;
  };
  CHECK(message({navigation, with(bench.local, bench.local, false), no_sd}).empty());
  CHECK(message({navigation, with(ecef, ecef, false), no_sd}).empty());
  const AdditiveKind speed(3, "m/s");
  CHECK(says(message({navigation, with(speed, speed, false), no_sd}),
             "/blocks/position: a position is of the kind 'position', 'position.ecef' or 'vector:3:m'; found "
             "'vector:3:m/s'"));
  const nlohmann::json in_ecef{{"frame", "ecef"}, {"sigma", 1}};
  CHECK(message({in_ecef, with(bench.geodetic, bench.geodetic, false), no_sd}).empty());
  CHECK(says(message({in_ecef, with(bench.local, bench.local, false), no_sd}),
             "/frame: \"frame\": \"ecef\" is for a position on the earth"));
  CHECK(says(message({in_ecef, with(ecef, ecef, true), no_sd}),
             "/blocks/attitude: \"frame\": \"ecef\" takes no attitude"));
  CHECK(says(message({navigation, with(bench.local, bench.geodetic, false), no_sd}),
             "/blocks/copy: the copy is of the kind 'position', the position of the kind 'vector:3:m'"));
  CHECK(says(message({body, with(bench.local, bench.local, false), no_sd}),
             "/blocks: a displacement in body axes needs the attitude at its start"));
  CHECK(says(message({navigation, with(bench.local, bench.local, true), no_sd}),
             "/blocks/attitude: \"frame\": \"navigation\" takes no attitude"));
  CHECK(says(message({body, with(plane, plane, true), no_sd}), "body axes are three"));
  CHECK(
      says(message({{{"frame", "navigation"}}, with(bench.local, bench.local, false), no_sd}), "missing key 'sigma'"));
  CHECK(says(message({navigation, with(bench.local, bench.local, false), {"dy"}}),
             "/fields: the channel carries no field for 'dy'"));
}

// ---- simulated displacements

namespace {

struct Said {
  int channel;
  Time t, t0;
  std::vector<double> fields;
};

class Path final : public Emitter {
 public:
  Path(nlohmann::json parameters, std::vector<std::string> without, std::uint64_t seed = 3)
      : transform_(bind<Displacement>({std::move(parameters), {}, std::move(without)})),
        memory_(transform_->declaration().memory_bytes) {
    for (const auto& channel : transform_->declaration().channels) fields_.emplace_back(channel.fields.size());
    writers_.resize(fields_.size());
    transform_->start(seed, memory_.data());
  }
  void at(double t, const std::vector<double>& fields) {
    SampleView sample;
    sample.t = nanoseconds(t);
    sample.fields = fields.data();
    transform_->on({Input(0, true), sample, memory_.data()}, *this);
  }
  SampleWriter& on(OutputChannel channel) override {
    const auto i = static_cast<std::size_t>(channel.index());
    writers_[i] = {.fields = fields_[i].data(), .field_count = static_cast<int>(fields_[i].size())};
    return writers_[i];
  }
  void emit(OutputChannel channel) override {
    const auto i = static_cast<std::size_t>(channel.index());
    said.push_back({channel.index(), writers_[i].t, writers_[i].t0, fields_[i]});
  }
  void emit_again(OutputChannel) override {}
  const StreamDeclaration& declaration() const { return transform_->declaration(); }

  std::vector<Said> said;

 private:
  std::unique_ptr<Displacement> transform_;
  std::vector<std::byte> memory_;
  std::vector<std::vector<double>> fields_;
  std::vector<SampleWriter> writers_;
};

const std::vector<std::string> no_local{"x", "y", "z"}, no_geodetic{"lat", "lon", "height"};

/// lat, lon, height, x, y, z, roll, pitch, yaw
std::vector<double> local_sample(const Vector3d& p, const Vector3d& euler) {
  return {0, 0, 0, p[0], p[1], p[2], euler[0], euler[1], euler[2]};
}

}  // namespace

TEST_CASE("displacement: the way from a begin that was its last end, in the axes of the begin", "[clone]") {
  Path path({{"every", 1}}, no_geodetic);
  const Vector3d turned(0, 0, M_PI / 2);
  path.at(0, local_sample({0, 0, 0}, {0, 0, 0}));
  path.at(0.5, local_sample({9, 9, 9}, {0, 0, 0}));
  path.at(1, local_sample({3, 4, 1}, turned));
  path.at(1.9, local_sample({NAN, 0, 0}, turned));
  path.at(2.5, local_sample({3, 10, 1}, turned));  // after a hole
  REQUIRE(path.said.size() == 4);
  CHECK(path.said[0].t0 == 0);
  CHECK(path.said[0].t == nanoseconds(1));
  CHECK(path.said[0].fields == std::vector<double>{3, 4, 1});
  CHECK(path.said[1].fields == std::vector<double>{3, 4, 1});
  CHECK(path.said[2].t0 == nanoseconds(1));
  CHECK(path.said[2].t == nanoseconds(2.5));
  // Heading east, the way to the east is forward.
  CHECK(std::abs(path.said[2].fields[0] - 6) < 1e-12);
  CHECK(std::abs(path.said[2].fields[1]) < 1e-12);
  CHECK(std::abs(path.said[3].fields[0] - 4) < 1e-12);
}

TEST_CASE("displacement: relative_position finds what it says, on the ellipsoid", "[clone]") {
  const Way bench;
  const Vector3d then(0.85, 2.1, 300), now = strapdown::position_plus(then, {40, -25, 3}), euler(0.3, -0.2, -0.5);
  Path path({{"every", 1}}, no_local);
  const auto sample = [](const Vector3d& lla, const Vector3d& angles) {
    return std::vector<double>{lla[0], lla[1], lla[2], 0, 0, 0, angles[0], angles[1], angles[2]};
  };
  path.at(2.0, sample(then, euler));
  path.at(3.0, sample(now, {0.1, 0.1, 0.1}));
  REQUIRE(path.said.size() == 2);
  const auto model = bind<RelativePosition>(
      {{{"sigma", 0.1}},
       {{"position", &bench.geodetic}, {"copy", &bench.geodetic}, {"attitude", &bench.attitude}, {"age", &bench.age}},
       no_sd});
  PortStates ports = bench.geodetic_ports(0.85, {40, -25, 3}, true);
  ports[3].x[0] = 1;
  std::vector<double> z = path.said[0].fields;
  z.insert(z.end(), {0, 0, 0});
  Complaints out;
  CHECK(linearize(*model, displacement(z, 3, 2), ports, {}, out).residual.norm() < 1e-8);
}

TEST_CASE("displacement: of a sensor at a lever arm, which a turn moves, and in ECEF axes", "[clone]") {
  // 2 m ahead of a body that turns to the east where it stands: to the side by 2 m, and back by as much.
  Path path({{"every", 1}, {"lever_arm", {2, 0, 0}}}, no_geodetic);
  path.at(0, local_sample({5, 5, 5}, {0, 0, 0}));
  path.at(1, local_sample({5, 5, 5}, {0, 0, M_PI / 2}));
  REQUIRE(path.said.size() == 2);
  CHECK((Vector3d(path.said[0].fields.data()) - Vector3d(-2, 2, 0)).norm() < 1e-12);

  const Vector3d then(0.85, 2.1, 300), now = strapdown::position_plus(then, {40, -25, 3});
  Path of_earth({{"every", 1}, {"frame", "ecef"}}, {"x", "y", "z", "roll"});
  of_earth.at(0, {then[0], then[1], then[2], 0, 0, 0, 0, 0, 0});
  of_earth.at(1, {now[0], now[1], now[2], 0, 0, 0, 0, 0, 0});
  const Vector3d d = strapdown::ecef_from_lla(now) - strapdown::ecef_from_lla(then);
  CHECK((Vector3d(of_earth.said.at(0).fields.data()) - d).norm() < 1e-9);
  CHECK_THROWS_AS(bind<Displacement>({{{"every", 1}, {"frame", "ecef"}}, {}, no_geodetic}), ComponentError);
  CHECK_THROWS_AS(bind<Displacement>(
                      {{{"every", 1}, {"frame", "ecef"}, {"lever_arm", {1, 0, 0}}}, {}, {"x", "y", "z", "yaw"}}),
                  ComponentError);
}

TEST_CASE("displacement: its noise has the size that it reports", "[clone]") {
  Path path({{"every", 1}, {"sigma", {0.1, 0.2, 0.3}}, {"relative", 0.05}, {"frame", "navigation"}}, no_geodetic);
  REQUIRE(path.declaration().channels[0].fields.size() == 6);
  constexpr int count = 4000;
  for (int k = 0; k <= count; ++k) path.at(k, local_sample({3.0 * k, 4.0 * k, 0}, {0, 0, 0}));
  Vector3d mean = Vector3d::Zero(), squares = Vector3d::Zero();
  for (const Said& said : path.said) {
    if (said.channel != 0) continue;
    const Vector3d e(said.fields[0] - 3, said.fields[1] - 4, said.fields[2]);
    mean += e / count;
    squares += e.cwiseAbs2() / count;
    for (std::size_t i = 0; i < 3; ++i)
      REQUIRE(std::abs(said.fields[3 + i] - std::sqrt(std::pow(0.1 * static_cast<double>(i + 1), 2) + 0.0625)) < 1e-12);
  }
  for (int i = 0; i < 3; ++i) {
    const double variance = std::pow(0.1 * (i + 1), 2) + 0.0625;
    CHECK(std::abs(mean[i]) < 3.5 * std::sqrt(variance / count));
    CHECK(std::abs(squares[i] / variance - 1) < 3.5 * std::sqrt(2.0 / count));
  }
}

TEST_CASE("displacement: a path without position, or without the attitude that it needs", "[clone]") {
  std::vector<std::string> neither = no_local;
  neither.insert(neither.end(), no_geodetic.begin(), no_geodetic.end());
  CHECK_THROWS_AS(bind<Displacement>({{{"every", 1}}, {}, neither}), ComponentError);
  CHECK_THROWS_AS(bind<Displacement>({{{"every", 1}}, {}, {"x", "y", "z", "yaw"}}), ComponentError);
  CHECK_NOTHROW(bind<Displacement>({{{"every", 1}, {"frame", "navigation"}}, {}, {"x", "y", "z", "yaw"}}));
}

}  // namespace clone_test
