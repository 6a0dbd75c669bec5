// SPDX-License-Identifier: Apache-2.0
// Noise larger than claimed: R is widened by what the rows scatter, P is not opened; a true change is not taken for noise.
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "catch.hpp"
#include "line.hpp"

namespace scatter_test {

using namespace binnacle;
using filter_tests::composition_of;
using filter_tests::push;
using filter_tests::reason_of;
using filter_tests::receiver;

namespace {

constexpr double claimed = 0.5;       // m
constexpr double acceleration = 0.1;  // m/s/sqrt(s)

const std::string by_row = R"("gate": {"probability": 0.9999, "by": "row"}, "recover": {"widen": true}, )",
                  by_sample = R"("gate": 0.9999, "recover": {"widen": true}, )";

/// One random walk of the velocity, seen once a second by a receiver that scatters by `scatter`; `wrong` is added to the
/// position that it gives.
struct Drive {
  std::mt19937_64 random;
  std::normal_distribution<double> normal;
  double position = 0, velocity = 0;
  double scatter = claimed;
  explicit Drive(int seed, double its_scatter) : random(static_cast<unsigned>(seed)), scatter(its_scatter) {}

  void second(Session& session, int t, double wrong = 0) {
    push(session, "z", t, {position + wrong + scatter * normal(random), velocity + 0.1 * normal(random)});
  }
  void move() {
    const double a = acceleration * normal(random);
    position += velocity + a / 2;
    velocity += a;
  }
};

double position_of(const Session& session) { return session.state(FilterId{0})[0]; }

/// RMS from 100 s to 400 s.
double error(Session& session, Drive drive) {
  double sum = 0;
  for (int t = 0; t < 400; ++t, drive.move()) {
    drive.second(session, t);
    if (t >= 100) sum += std::pow(position_of(session) - drive.position, 2);
  }
  return std::sqrt(sum / 300);
}

}  // namespace

TEST_CASE("fixes that scatter by more than they claim: R is widened, and the error is that of the right sigma") {
  for (const std::string& gate : {by_row, by_sample})
    for (const double factor : {3.0, 5.0, 15.0}) {
      double own = 0, right = 0;
      for (int seed = 1; seed <= 20; ++seed) {
        CAPTURE(gate, factor, seed);
        Session session(composition_of(receiver(gate, claimed, acceleration)));
        own += std::pow(error(session, Drive(seed, factor * claimed)), 2);
        const auto found = reason_of(session, Doubt::scattered);
        if (factor > 4) REQUIRE(found);  // three times too small may be refused less than twenty times
        if (found) {
          CHECK(session.verdict({0}) != Verdict::ok);
          CHECK(found->limit == Approx(claimed));
          CHECK(found->figure > 0.6 * factor * claimed);
          CHECK(found->figure < 2.5 * factor * claimed);
        }
        Session honest(composition_of(receiver("", factor * claimed, acceleration)));
        right += std::pow(error(honest, Drive(seed, factor * claimed)), 2);
      }
      CAPTURE(gate, factor, std::sqrt(own / right));
      std::printf("scatter of %.0f times the claim, %s error over that of the right sigma %.2f\n", factor, gate.c_str(),
                  std::sqrt(own / right));
      CHECK(std::sqrt(own / right) < 1.7);
    }
}

TEST_CASE("a step, a ramp and a frozen position are no scatter, and nor are outliers") {
  for (const std::string& gate : {by_row, by_sample})
    for (int seed = 1; seed <= 60; ++seed)
      for (int kind = 0; kind < 4; ++kind) {
        CAPTURE(gate, seed, kind);
        Session session(composition_of(receiver(gate, claimed, acceleration)));
        Drive drive(seed, claimed);
        double frozen = 0;
        for (int t = 0; t < 300; ++t, drive.move()) {
          if (t == 150) frozen = drive.position;
          const bool is_outlier = t % 50 == 20;
          const double wrong = kind == 3   ? (is_outlier ? 20.0 : 0.0)
                               : t < 150   ? 0.0
                               : kind == 0 ? 50.0
                               : kind == 1 ? 2.0 * (t - 150)
                                           : frozen - drive.position;
          drive.second(session, t, wrong);
        }
        CHECK_FALSE(reason_of(session, Doubt::scattered));
      }
}

}  // namespace scatter_test
