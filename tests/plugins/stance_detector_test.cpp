// SPDX-License-Identifier: Apache-2.0
// Plugin stationary_detector, stance_detector: its statistic by hand, the threshold, what is lost in a hole.
#include "../../plugins/stationary_detector/stance_detector.hpp"
#include "binnacle/testing.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "bind.hpp"
#include "binnacle/view.hpp"
#include "catch.hpp"

namespace stance_detector_test {

using namespace binnacle;
using namespace binnacle::stationary_detector;
using namespace binnacle::test;
using Eigen::Vector3d;

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
enum Channel { standing, state };

struct Imu {
  Vector3d rate{0, 0, 0}, force{0, 0, -9.8};
};

class Bench {
 public:
  explicit Bench(const nlohmann::json& more = nlohmann::json::object()) {
    nlohmann::json parameters{{"samples", 5},   {"force_sigma", 0.01}, {"rate_sigma", 0.002},
                              {"gravity", 9.8}, {"threshold", 1e4},    {"max_gap", 0.05}};
    parameters.update(more);
    detector = bind<StanceDetector>({parameters, {}, {}});
    memory.resize(detector->declaration().memory_bytes);
    detector->start(1, memory.data());
  }
  void give(double t, const Imu& imu) {
    const double fields[] = {imu.rate[0], imu.rate[1], imu.rate[2], imu.force[0], imu.force[1], imu.force[2]};
    send(0, t, fields);
  }
  void bias(const Vector3d& bias) { send(1, 0, bias.data()); }
  /// At 100 Hz, from `first` on: each `count` times.
  void give(int first, int count, const Imu& imu) {
    for (int k = first; k < first + count; ++k) give(0.01 * k, imu);
  }
  std::vector<binnacle::testing::Emitted> of(int channel) const {
    std::vector<binnacle::testing::Emitted> some;
    for (const auto& one : all)
      if (one.channel == channel) some.push_back(one);
    return some;
  }
  double statistic() const { return of(state).back().fields[1]; }
  bool stands() const { return of(state).back().fields[0] == 1; }

  std::unique_ptr<StanceDetector> detector;
  std::vector<std::byte> memory;
  std::vector<binnacle::testing::Emitted> all;

 private:
  void send(std::size_t input, double t, const double* fields) {
    static const ComponentSpec spec = StanceDetector::spec();
    SampleView sample;
    sample.t = nanoseconds(t), sample.fields = fields;
    const auto made = binnacle::testing::TransformCaller(*detector, spec).on(input, sample, memory.data());
    REQUIRE(made.damage.empty());
    for (const auto& emitted : made.samples) all.push_back(emitted);
  }
};

}  // namespace

TEST_CASE("stance detector: the statistic of Skog et al., by hand") {
  // 1/W sum of |f - g f_mean/|f_mean||^2 / sigma_f^2 + |w|^2 / sigma_w^2, whatever the axes are.
  Bench bench;
  const std::vector<Imu> window{{{0.01, 0, 0}, {0.1, 0, -9.7}},
                                {{0, 0.02, 0}, {0, 0.2, -9.9}},
                                {{0, 0, -0.03}, {0, 0, -10}},
                                {{0.01, 0.01, 0}, {0, -0.1, -9.6}},
                                {{0, 0, 0}, {0.3, 0, -9.8}}};
  Vector3d mean = Vector3d::Zero();
  for (const Imu& imu : window) mean += imu.force / 5;
  double expected = 0;
  for (const Imu& imu : window)
    expected += ((imu.force - 9.8 * mean.normalized()).squaredNorm() / 1e-4 + imu.rate.squaredNorm() / 4e-6) / 5;
  for (std::size_t k = 0; k < 5; ++k) bench.give(0.01 * static_cast<double>(k), window[k]);
  REQUIRE(bench.of(state).size() == 1);
  CHECK(std::abs(bench.statistic() / expected - 1) < 1e-12);
  // Turned as a whole it is the same; upside down too.
  Bench turned;
  for (std::size_t k = 0; k < 5; ++k) turned.give(0.01 * static_cast<double>(k), {-window[k].rate, -window[k].force});
  CHECK(std::abs(turned.statistic() / expected - 1) < 1e-12);
}

TEST_CASE("stance detector: either energy ends a stance, and each side of the threshold") {
  for (const double share : {0.98, 1.02}) {
    INFO(share);
    // |w|^2/sigma^2 = 1e4 at 0.2 rad/s. A force along gravity that is off by d: d^2/sigma^2 = 1e4 at 1 m/s^2.
    Bench turning, heavy, light, shaken;
    turning.give(0, 5, {{0, -0.2 * share, 0}, {0, 0, -9.8}});
    heavy.give(0, 5, {{0, 0, 0}, {0, 0, -9.8 - share}});
    light.give(0, 5, {{0, 0, 0}, {9.8 - share, 0, 0}});
    for (int k = 0; k < 5; ++k) shaken.give(0.01 * k, {{0, 0, 0}, {k % 2 ? 1.1 * share : -1.1 * share, 0, -9.8}});
    CHECK(turning.stands() == (share < 1));
    CHECK(heavy.stands() == (share < 1));
    CHECK(light.stands() == (share < 1));
    CHECK(turning.of(standing).size() == (share < 1 ? 1u : 0u));
    CHECK(std::abs(turning.statistic() - 1e4 * share * share) < 1e-6);
  }
  Bench tilted;  // The direction of a steady force is no motion.
  tilted.give(0, 5, {{0, 0, 0}, 9.8 * Vector3d(0.6, 0, -0.8)});
  CHECK(tilted.statistic() < 1e-12);
}

TEST_CASE("stance detector: the window slides, and reports the newest sample") {
  Bench bench;
  bench.give(0, 10, {});
  CHECK(bench.of(state).size() == 6);
  CHECK(bench.of(state)[0].t == nanoseconds(0.04));
  const auto all = bench.of(standing);
  REQUIRE(all.size() == 6);
  CHECK((all[2].t == nanoseconds(0.06) && all[2].t0 == nanoseconds(0.05)));
  CHECK(all[2].fields[5] == -9.8);
  // One sample of a swing stays in the window for five.
  bench.give(10, 1, {{0, 1, 0}, {0, 0, -9.8}});
  bench.give(11, 6, {});
  std::vector<double> stands;
  for (const auto& one : bench.of(state)) stands.push_back(one.fields[0]);
  CHECK(stands == std::vector<double>{1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 1, 1});
}

TEST_CASE("stance detector: a hole, a time that goes back and a sample that is no number empty the window") {
  const auto after = [](const std::function<void(Bench&)>& spoil) {
    Bench bench;
    bench.give(0, 8, {});
    spoil(bench);
    const std::size_t before = bench.all.size();
    // Four samples are not a window, whatever was before the hole.
    bench.give(20, 4, {});
    const bool is_silent = bench.all.size() == before;
    bench.give(24, 1, {});
    return is_silent && bench.all.size() == before + 2;
  };
  CHECK(after([](Bench&) {}));
  CHECK(after([](Bench& bench) {
    bench.give(19, 1, {});
    bench.give(0.195, {{0, 0, unknown}, {0, 0, -9.8}});
  }));
  Bench back;
  back.give(0, 8, {});
  const std::size_t before = back.all.size();
  back.give(0, 4, {});
  CHECK(back.all.size() == before);
  Bench twice;  // The same sample again is not one more.
  twice.give(0, 4, {});
  twice.give(0.03, {});
  CHECK(twice.all.empty());
  Bench jitter;  // One sample that is lost is no hole.
  jitter.give(0, 4, {});
  jitter.give(0.05, {});
  CHECK(jitter.of(state).size() == 1);
}

TEST_CASE("stance detector: a bias is taken off the rates, and not off what it reports") {
  Bench bench;
  bench.bias({0.3, 0, 0});
  bench.give(0, 5, {{0.3, 0, 0}, {0, 0, -9.8}});
  CHECK(bench.statistic() < 1e-12);
  REQUIRE(bench.of(standing).size() == 1);
  CHECK(bench.of(standing)[0].fields[0] == 0.3);
}

}  // namespace stance_detector_test
