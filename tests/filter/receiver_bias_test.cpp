// SPDX-License-Identifier: Apache-2.0
// A receiver whose position is off by metres for minutes and reports decimetres: with the bias as a block the filter is
// consistent, and overconfident where it takes all for white noise.
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "binnacle/state_block.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace receiver_bias_test {

using namespace binnacle;
using filter_tests::composition_of;

namespace {

constexpr double tau = 60, sigma = 2, white = 0.3, start = 10;  // [s]; [m], as the configs below have it

/// An antenna that stands; `bias`: what the fix has bound besides the position.
std::string filter(const std::string& bias) {
  return R"({"blocks": {
      "position": {"type": "position", "init": {"lat": "48 deg", "lon": "11 deg", "height": 500}, "sigma": "10 m"},
      "bias": {"type": "vector", "size": 3, "unit": "m", "sigma": "2 m"}},
    "process": {
      "stand": {"type": "random_constant", "blocks": {"x": "position"}},
      "wander": {"type": "gauss_markov", "blocks": {"x": "bias"}, "tau": "60 s", "sigma": "2 m"}},
    "measurements": {
      "fix": {"type": "position_fix", "channel": "gnss", "blocks": {"position": "position")" +
         bias + R"(}, "sigma": "0.3 m"}}})";
}

std::shared_ptr<const Composition> composition() {
  return composition_of(R"({"binnacle": 1,
    "sources": {"gnss": {"type": "pushed",
                         "fields": {"lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"}}}},
    "filters": {"with": )" +
                        filter(R"(, "bias": "bias")") + R"(, "without": )" + filter("") + "}}");
}

/// Of the block's error; truth: what it should store.
double nees(const Session& session, const std::string& name, const std::vector<double>& truth) {
  const BlockId id = session.block(name);
  const auto& info = session.composition()
                         .filters()[static_cast<std::size_t>(id.filter.index)]
                         .blocks[static_cast<std::size_t>(id.index)];
  Eigen::Vector3d error;
  info.block->minus(truth, session.state(id.filter).subspan(static_cast<std::size_t>(info.stored_offset), 3),
                    {error.data(), 3});
  return error.dot(Eigen::Matrix3d(session.covariance(id).as()).ldlt().solve(error));
}

class Normal {
 public:
  explicit Normal(unsigned seed) : engine_(seed) {}
  Eigen::Vector3d operator()(double size) {
    return size * Eigen::Vector3d::NullaryExpr([&](Eigen::Index) { return normal_(engine_); });
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

}  // namespace

TEST_CASE("a correlated error of the receiver: consistent with a bias block, far from it without") {
  constexpr int runs = 100;
  constexpr std::array instants{0, 30, 300};
  const auto composed = composition();
  const StateBlock& position = *composed->filters()[0].blocks[0].block;
  const std::vector<double> initial = composed->filters()[0].blocks[0].initial;
  const auto moved = [&](const std::vector<double>& from, const Eigen::Vector3d& by) {
    std::vector<double> to(3);
    position.plus(from, {by.data(), 3}, to);
    return to;
  };
  std::array<std::array<double, 3>, instants.size()> mean{};  // of the position, of the bias; of the position without
  Session session(composed);
  const ChannelId gnss = session.channel("gnss");
  for (unsigned run = 0; run < runs; ++run) {
    session.reset();
    Normal normal(run);
    const std::vector<double> truth = moved(initial, normal(start));
    Eigen::Vector3d bias = normal(sigma);
    for (int t = 0; t <= instants.back(); ++t) {
      session.push(gnss, no_time, nanoseconds(t), moved(truth, bias + normal(white)));
      for (std::size_t i = 0; i < instants.size(); ++i) {
        if (t != instants[i]) continue;
        mean[i][0] += nees(session, "with/position", truth) / runs;
        mean[i][1] += nees(session, "with/bias", {bias[0], bias[1], bias[2]}) / runs;
        mean[i][2] += nees(session, "without/position", truth) / runs;
      }
      const double a = std::exp(-1 / tau);
      bias = a * bias + normal(sigma * std::sqrt(1 - a * a));
    }
  }
  for (std::size_t i = 0; i < instants.size(); ++i) {
    CAPTURE(instants[i], mean[i][0], mean[i][1], mean[i][2]);
    // χ² of 300 degrees of freedom, 99 %.
    CHECK((mean[i][0] > 3 * 0.802 && mean[i][0] < 3 * 1.223));
    CHECK((mean[i][1] > 3 * 0.802 && mean[i][1] < 3 * 1.223));
    CHECK(mean[i][2] > 3 * 10);
  }
}

}  // namespace receiver_bias_test
