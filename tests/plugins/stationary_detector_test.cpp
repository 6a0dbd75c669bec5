// SPDX-License-Identifier: Apache-2.0
// Plugin stationary_detector: delays on steps, the counter, vibration, holes, what the channels carry; the score.
#include "../../plugins/stationary_detector/stationary_detector.hpp"
#include "../../plugins/stationary_detector/detection_score.hpp"
#include "binnacle/testing.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "bind.hpp"
#include "binnacle/view.hpp"
#include "catch.hpp"

namespace stationary_detector_test {

using namespace binnacle;
using namespace binnacle::stationary_detector;
using namespace binnacle::test;
using Eigen::Vector3d;

namespace {

constexpr double degree = M_PI / 180, earth = 7.292115e-5, unknown = std::numeric_limits<double>::quiet_NaN();
enum Channel { standing, moving, state };

struct Said {
  int channel;
  double t, t0;
  std::array<double, 6> fields;
};

class Collector {
 public:
  template <class Detector>
  void receive(const Detector& detector, std::size_t input, const SampleView& sample, std::vector<std::byte>& memory) {
    static const ComponentSpec spec = Detector::spec();
    const auto made = binnacle::testing::TransformCaller(detector, spec).on(input, sample, memory.data());
    REQUIRE(made.damage.empty());
    for (const auto& emitted : made.samples) {
      Said one{emitted.channel, seconds(emitted.t), emitted.t0 == no_time ? unknown : seconds(emitted.t0), {}};
      one.fields.fill(unknown);
      std::copy(emitted.fields.begin(), emitted.fields.end(), one.fields.begin());
      said.push_back(one);
    }
  }
  std::vector<Said> of(int channel) const {
    std::vector<Said> some;
    for (const Said& one : said)
      if (one.channel == channel) some.push_back(one);
    return some;
  }
  std::vector<Said> said;
};

struct Motion {
  Vector3d rate{0, 0, earth}, force{0, 0, -9.80};
};

nlohmann::json with(const nlohmann::json& parameters) {
  nlohmann::json all{{"window", 1.0}, {"rate_threshold", 0.02 * degree}, {"on", 1.5}, {"off", 0.5}, {"max_gap", 0.5}};
  all.update(parameters);
  return all;
}

/// The detector on a motion, sampled at a rate.
class Bench {
 public:
  explicit Bench(const nlohmann::json& parameters = nlohmann::json::object())
      : detector(bind<StationaryDetector>({with(parameters), {}, {}})), memory(detector->declaration().memory_bytes) {
    detector->start(1, memory.data());
  }
  void imu(double t0, double t, const Motion& motion) {
    const double fields[] = {motion.rate[0],  motion.rate[1],  motion.rate[2],
                             motion.force[0], motion.force[1], motion.force[2]};
    SampleView sample;
    sample.t0 = nanoseconds(t0), sample.t = nanoseconds(t), sample.fields = fields;
    collected.receive(*detector, 0, sample, memory);
  }
  void bias(double x, double y, double z) {
    const double fields[] = {x, y, z};
    SampleView sample;
    sample.t = 0, sample.fields = fields;
    collected.receive(*detector, 1, sample, memory);
  }
  void drive(double from, double to, double rate, const std::function<Motion(double)>& motion) {
    for (int k = static_cast<int>(std::lround(from * rate)); k < std::lround(to * rate); ++k)
      imu(k / rate, (k + 1) / rate, motion((k + 0.5) / rate));
  }
  /// Times at which the state became 1, or 0.
  std::vector<double> changes_to(double value) const {
    std::vector<double> times;
    double before = unknown;
    for (const Said& one : collected.of(state)) {
      if (one.fields[0] == value && before != value) times.push_back(one.t);
      before = one.fields[0];
    }
    return times;
  }

  std::unique_ptr<StationaryDetector> detector;
  std::vector<std::byte> memory;
  Collector collected;
};

std::function<Motion(double)> turning_between(double from, double to, double rate) {
  return [=](double t) {
    Motion motion;
    if (t > from && t < to) motion.rate[1] = rate;
    return motion;
  };
}

void require_one(const std::vector<double>& times, double low, double high) {
  REQUIRE(times.size() == 1);
  INFO(times[0] << " in " << low << " … " << high);
  REQUIRE((times[0] > low && times[0] < high));
}

}  // namespace

TEST_CASE("stationary detector: delays on a step of the rate, at any sample rate") {
  for (const double rate : {50.0, 62.5, 100.0, 104.0, 200.0, 400.0}) {
    INFO(rate << " Hz");
    Bench bench;
    bench.drive(0, 40, rate, turning_between(10, 20, 1 * degree));
    // First a full window (1 s), of which each part counts, then the counter (1.5 s): 2.45 s.
    const auto on = bench.changes_to(1);
    REQUIRE(on.size() == 2);
    REQUIRE(std::abs(on[0] - 2.47) < 0.07);
    // The mean reaches a fiftieth of the step after 0.02 s and the filter's lag; then the counter of 0.5 s.
    require_one(bench.changes_to(0), 10.5, 10.75);
    // The window has to be rid of the motion, 1 s and the filter's tail, and then 1.5 s.
    REQUIRE((on[1] > 22.5 && on[1] < 23.0));
  }
}

TEST_CASE("stationary detector: the counter outlasts a shake") {
  Bench steady(nlohmann::json{{"off", 2.0}}), hasty;
  steady.drive(0, 20, 200, turning_between(10, 10.3, 1 * degree));
  hasty.drive(0, 20, 200, turning_between(10, 10.3, 1 * degree));
  REQUIRE(steady.changes_to(0).empty());
  REQUIRE(hasty.changes_to(0).size() == 1);
  steady.drive(20, 30, 200, turning_between(22, 30, 1 * degree));
  require_one(steady.changes_to(0), 24.0, 24.3);
}

TEST_CASE("stationary detector: (11) is about the earth's rate, and a bias is taken off") {
  const auto still_with = [](double rate) {
    return [rate](double) {
      Motion motion;
      motion.rate = {0, 0, rate};
      return motion;
    };
  };
  // The threshold is 0.02 deg/s = 3.49e-4 rad/s on either side of 7.3e-5 rad/s.
  for (const auto& [rate, expected] : {std::pair{earth, 1}, {earth + 3.4e-4, 1}, {earth + 3.6e-4, 0}, {0.0, 1}}) {
    Bench bench;
    bench.drive(0, 5, 100, still_with(rate));
    REQUIRE(bench.changes_to(expected).size() == 1);
    REQUIRE(bench.changes_to(1 - expected).empty());
  }
  Bench bench;
  bench.bias(0, 0, 0.01);
  bench.drive(0, 5, 100, still_with(0.01 + earth));
  REQUIRE(bench.changes_to(1).size() == 1);
}

TEST_CASE("stationary detector: (12) is about the variance, after the low-pass") {
  const auto step = [](double size) {
    return [size](double t) {
      Motion motion;
      if (t > 10) motion.force[2] -= size;
      return motion;
    };
  };
  Bench small, large;  // a step of A has at most the variance A²/4 in a window
  small.drive(0, 20, 100, step(0.03));
  large.drive(0, 20, 100, step(0.06));
  REQUIRE(small.changes_to(0).empty());
  REQUIRE(large.changes_to(0).size() == 1);
  REQUIRE(large.changes_to(1).size() == 2);

  // An engine: 0.5 m/s² at 25 Hz. Two poles at 3.1 Hz leave 0.008 m/s² of it, without them it is not at rest.
  const auto engine = [](double t) {
    Motion motion;
    motion.force[2] += 0.5 * std::sin(2 * M_PI * 25 * t);
    return motion;
  };
  Bench filtered, raw(nlohmann::json{{"cutoff", 1000}});
  filtered.drive(0, 10, 200, engine);
  raw.drive(0, 10, 200, engine);
  REQUIRE(filtered.changes_to(1).size() == 1);
  REQUIRE(filtered.changes_to(0).empty());
  REQUIRE(raw.changes_to(1).empty());
}

TEST_CASE("stationary detector: -3 dB at the cutoff") {
  // Variance of a sine of amplitude A behind the filter is A²/4 at the cutoff, so the threshold lies at A = 2 s.
  for (const auto& [amplitude, expected] : {std::pair{0.97 * 0.04, 1}, {1.03 * 0.04, 0}}) {
    Bench bench;
    bench.drive(0, 10, 400, [a = amplitude](double t) {
      Motion motion;
      motion.force[2] += a * std::sin(2 * M_PI * 2 * t);
      return motion;
    });
    REQUIRE(bench.changes_to(expected).size() == 1);
    REQUIRE(bench.changes_to(1 - expected).empty());
  }
}

TEST_CASE("stationary detector: what the channels carry, and how often") {
  Bench bench(nlohmann::json{{"standing_rate", 5.0}, {"moving_rate", 2.0}});
  const auto motion = [](double t) {
    Motion now = turning_between(10, 30, 1 * degree)(t);
    now.force[0] = 0.01 * t;
    return now;
  };
  bench.drive(0, 30, 200, motion);
  const auto still = bench.collected.of(standing), driving = bench.collected.of(moving);
  const double on = bench.changes_to(1).at(0), off = bench.changes_to(0).at(0);
  REQUIRE(std::abs(static_cast<double>(still.size()) - 5 * (off - on)) <= 1);
  REQUIRE(std::abs(static_cast<double>(driving.size()) - 2 * (30 - off)) <= 1);
  for (std::size_t i = 0; i < still.size(); ++i) {
    REQUIRE(std::abs(still[i].t - still[i].t0 - 0.2) < 1e-9);
    REQUIRE(std::abs(still[i].t0 - (i ? still[i - 1].t : on)) < 1e-9);
    REQUIRE(std::abs(still[i].fields[2] - earth) < 1e-12);
    REQUIRE(std::abs(still[i].fields[3] - 0.005 * (still[i].t0 + still[i].t)) < 1e-9);
  }
  REQUIRE(std::abs(driving[0].t0 - off) < 1e-9);
  REQUIRE(std::abs(driving[0].fields[1] - 1 * degree) < 1e-9);
  for (const Said& one : driving) REQUIRE(one.t > off);
}

TEST_CASE("stationary detector: samples that are not finite or come twice are left out, a gap begins anew") {
  Bench bench;
  const auto at_rest = [](double) { return Motion(); };
  bench.drive(0, 5, 100, at_rest);
  Motion broken;
  broken.rate[1] = unknown;
  bench.imu(5, 5.01, broken);
  bench.imu(4.9, 5.0, {});
  bench.drive(5.02, 8, 100, at_rest);
  REQUIRE(bench.changes_to(1).size() == 1);
  REQUIRE(bench.changes_to(0).empty());

  const std::size_t before = bench.collected.said.size();
  bench.drive(10, 12.3, 100, at_rest);
  REQUIRE(bench.collected.said.size() == before);
  bench.drive(12.3, 14, 100, at_rest);
  REQUIRE(bench.collected.said.size() > before);
  REQUIRE(bench.collected.said[before].t > 12.4);

  const std::size_t then = bench.collected.said.size();
  bench.imu(3, 3.01, {});  // time goes back: anew as well
  bench.drive(3.01, 5, 100, at_rest);
  REQUIRE(bench.collected.said.size() == then);
}

TEST_CASE("stationary detector: restored from a copy of its memory it goes on as before") {
  Bench one, two;
  const auto motion = turning_between(5, 7.3, 1 * degree);
  one.drive(0, 6.123, 100, motion);
  two.memory = one.memory;
  one.collected.said.clear();
  one.drive(6.12, 20, 100, motion);
  two.drive(6.12, 20, 100, motion);
  REQUIRE(one.collected.said.size() == two.collected.said.size());
  for (std::size_t i = 0; i < one.collected.said.size(); ++i)
    REQUIRE(one.collected.said[i].t == two.collected.said[i].t);
}

TEST_CASE("detection score: missed and false seconds") {
  const auto score = bind<DetectionScore>({{{"after", 1.0}}, {}, {}});
  std::vector<std::byte> memory(score->declaration().memory_bytes);
  score->start(1, memory.data());
  Collector collected;
  const auto push = [&](std::size_t input, double t, double value) {
    SampleView sample;
    sample.t = nanoseconds(t), sample.fields = &value;
    collected.receive(*score, input, sample, memory);
  };
  // Stands from 0 to 10 and from 20; the detector says so from 3 to 12 and from 21.5.
  for (int k = 0; k <= 300; ++k) {
    const double t = 0.1 * k;
    if (k == 30 || k == 215) push(0, t, 1);
    if (k == 120) push(0, t, 0);
    push(1, t, t < 9.999 || t > 19.999 ? 1 : 0);
  }
  const auto& last = collected.said.back().fields;
  REQUIRE(std::abs(last[0] - (2.0 + 1.5)) < 0.11);
  REQUIRE(std::abs(last[1] - 2.0) < 0.11);
  REQUIRE(std::abs(last[2] - 19) < 0.11);
  REQUIRE(std::abs(last[3] - 10) < 0.11);
}

TEST_CASE("asked to emit as often as it receives, or more often, it emits nothing for no time at all",
          "[stationary_detector]") {
  for (const double rate : {50.0, 100.0, 1000.0}) {
    Bench bench({{"standing_rate", rate}, {"moving_rate", rate}});
    bench.drive(0, 6, 50, [](double) { return Motion{}; });
    bench.drive(6, 12, 50, [](double t) {
      return Motion{{0.1 * std::sin(20 * t), 0, 0.2}, {std::sin(30 * t), 0, -9.8}};
    });
    CAPTURE(rate);
    REQUIRE(!bench.collected.of(standing).empty());
    REQUIRE(!bench.collected.of(moving).empty());
    for (const int channel : {standing, moving})
      for (const Said& said : bench.collected.of(channel)) {
        REQUIRE(said.t > said.t0);
        for (const double field : said.fields) REQUIRE(std::isfinite(field));
      }
  }
}

}  // namespace stationary_detector_test
