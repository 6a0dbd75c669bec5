// SPDX-License-Identifier: Apache-2.0
// The verdict: what a right filter is called, and a wrong one, and which reasons are given; recovery from a lock-out.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace trust_test {

using namespace binnacle;

using filter_tests::composition_of;
using filter_tests::fix_and_speed;
using filter_tests::line;
using filter_tests::push;

namespace {

/// A truth that moves as the filter of line() assumes, from an initial value that it assumes too.
class Truth {
 public:
  explicit Truth(unsigned seed) : random_(seed) {
    position_ = 1 + 2 * normal();
    velocity_ = 0.5 + 0.3 * normal();
  }
  void advance(double dt) {
    constexpr double q = 0.2 * 0.2;
    // Qd of an integrated random walk, by its Cholesky factor.
    const double v = std::sqrt(q * dt) * normal(), rest = std::sqrt(q * dt * dt * dt / 12) * normal();
    position_ += velocity_ * dt + 0.5 * dt * v + rest;
    velocity_ += v;
  }
  double seen() { return position_ + 0.7 * normal(); }
  double position() const { return position_; }
  double velocity() const { return velocity_; }
  double normal() { return normal_(random_); }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  double position_ = 0, velocity_ = 0;
};

const std::string gated = R"(, "gate": 0.999)";

/// Ten minutes with a sample each half second, spoilt by `spoil(t, z, truth)`.
template <class Spoil>
Session run(const std::shared_ptr<const Composition>& composition, unsigned seed, Spoil&& spoil) {
  Session session(composition);
  Truth truth(seed);
  const ChannelId channel = session.channel("z");
  for (int i = 0; i <= 1200; ++i) {
    const double t = 0.5 * i;
    if (i > 0) truth.advance(0.5);
    const double z = spoil(t, truth.seen(), truth);
    session.push(channel, no_time, nanoseconds(t), {&z, 1});
  }
  return session;
}

double clean(double /*t*/, double z, Truth& /*truth*/) { return z; }

bool has_code(const Session& session, const std::string& code) {
  const Diagnostics doubts = session.doubts(FilterId{0});
  const auto& items = doubts.items();
  return std::ranges::any_of(items, [&](const Diagnostic& item) { return item.code == code; });
}

std::string said(const Session& session) {
  std::string all = verdict_name(session.verdict(FilterId{0}));
  const Diagnostics doubts = session.doubts(FilterId{0});
  for (const auto& item : doubts.items()) all += "\n" + item.code + " " + item.message;
  return all;
}

}  // namespace

TEST_CASE("of a thousand right runs of ten minutes at most four are doubtful, and none is lost") {
  for (const auto& gate : {std::string(), gated}) {
    const auto composition = composition_of(line("", gate));
    std::array<int, 3> verdicts{};
    for (unsigned seed = 0; seed < 1000; ++seed)
      ++verdicts[static_cast<std::size_t>(run(composition, seed, clean).verdict(FilterId{0}))];
    INFO(gate);
    CHECK(verdicts[1] <= 4);
    CHECK(verdicts[2] == 0);
  }
}

TEST_CASE("noise that is larger than specified is doubtful, and the summary says what would fit") {
  const auto composition = composition_of(line());
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Session session =
        run(composition, seed, [](double, double z, Truth& truth) { return z + 1.0 * truth.normal(); });
    INFO(said(session));
    CHECK(session.verdict(FilterId{0}) == Verdict::doubtful);
    CHECK(has_code(session, "B103"));
    const auto rows = session.counts(MeasurementId{{0}, 0}).rows;
    REQUIRE(rows.size() == 1);
    CHECK(rows[0].used == 1201);
    CHECK(rows[0].rms > 1.3);
    CHECK(std::abs(rows[0].sigma - 0.7) < 1e-12);
    CHECK(std::abs(rows[0].fitting_sigma - std::hypot(0.7, 1.0)) < 0.25);
  }
}

TEST_CASE("noise that is white but ten times as large is lost") {
  const auto composition = composition_of(line());
  const Session session = run(composition, 1, [](double, double z, Truth& truth) { return z + 7.0 * truth.normal(); });
  INFO(said(session));
  CHECK(session.verdict(FilterId{0}) == Verdict::lost);
}

TEST_CASE("errors that are correlated in time are doubtful") {
  const auto composition = composition_of(line());
  for (unsigned seed = 0; seed < 20; ++seed) {
    double error = 0;
    const Session session = run(composition, seed, [&](double, double z, Truth& truth) {
      error = 0.9 * error + 0.6 * truth.normal();
      return z + error;
    });
    INFO(said(session));
    CHECK(session.verdict(FilterId{0}) == Verdict::doubtful);
    CHECK((has_code(session, "B105") || has_code(session, "B103")));
  }
}

TEST_CASE("a measurement that is never accepted is lost, with its reason") {
  const auto composition = composition_of(line("", gated + R"(, "recover": false)"));
  const Session session = run(composition, 3, [](double, double z, Truth&) { return z + 1e6; });
  INFO(said(session));
  CHECK(session.verdict(FilterId{0}) == Verdict::lost);
  CHECK(has_code(session, "B101"));
  CHECK(said(session).find("the last because NIS beyond the gate") != std::string::npos);
  CHECK(said(session).find("of 'f' was used: the last was refused because NIS beyond the gate") != std::string::npos);
}

TEST_CASE("samples whose own standard deviation is none are invalid, noted by field, and lost where all are") {
  const auto composition = composition_of(R"({"binnacle": 1,
    "sources": {"gnss": {"type": "pushed", "fields": {
      "lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"},
      "position_sd_n": {"unit": "m"}, "position_sd_e": {"unit": "m"}, "position_sd_d": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"position": {"type": "navigation/position", "init": {"lat": 0.6, "lon": 2, "height": 0}, "sigma": 1}},
      "process": {"stay": {"type": "random_constant", "blocks": {"x": "position"}}},
      "measurements": {"fix": {"type": "position_fix", "channel": "gnss", "blocks": {"position": "position"}}}}}})");
  for (const double flaw : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    INFO(flaw);
    Session session(composition);
    for (int i = 1; i <= 10; ++i) push(session, "gnss", i, {0.6, 2, 0, 1, flaw, 1});
    CHECK(session.counts(MeasurementId{{0}, 0}).by_outcome[static_cast<int>(Outcome::invalid)] == 10);
    CHECK(session.verdict(FilterId{0}) == Verdict::lost);
    CHECK(has_code(session, "B101"));
    const Diagnostics all_notes = session.notes(FilterId{0});
    const auto& notes = all_notes.items();
    REQUIRE(notes.size() == 1);
    CHECK(notes[0].pointer == "/filters/f/measurements/fix");
    CHECK(notes[0].message.find("linearize at 1 s notes: invalid sample of 'gnss': position_sd_e is 0, negative or not "
                                "finite (10 times)") != std::string::npos);
    push(session, "gnss", 11, {0.6, 2, 0, 1, 1, 1});
    CHECK_FALSE(has_code(session, "B101"));
  }
}

TEST_CASE("a filter that locks itself out recovers by itself, says so, and is consistent again") {
  const auto composition = composition_of(line("", gated));
  double nees = 0;
  constexpr int runs = 50;
  for (unsigned seed = 0; seed < runs; ++seed) {
    double jump = 0;
    Truth* last = nullptr;
    double position = 0, velocity = 0;
    Session session = run(composition, seed, [&](double t, double z, Truth& truth) {
      if (t >= 300) jump = 500;  // the truth is elsewhere: all that comes from here on says so
      last = &truth;
      position = truth.position() + jump;
      velocity = truth.velocity();
      return z + jump;
    });
    INFO(said(session));
    CHECK(session.verdict(FilterId{0}) == Verdict::lost);  // there is no other measurement that confirms the jump
    CHECK(has_code(session, "B106"));
    const auto counts = session.counts(MeasurementId{{0}, 0});
    CHECK(counts.recoveries == 1);
    // Four in a row are refused, the fifth opens the covariance and is taken.
    CHECK(counts.by_outcome[static_cast<int>(Outcome::gated)] <= 12);
    CHECK(counts.by_outcome[static_cast<int>(Outcome::gated)] >= 4);
    Eigen::Vector2d error(session.state(FilterId{0})[0] - position, session.state(FilterId{0})[1] - velocity);
    nees += error.dot(Eigen::Matrix2d(session.covariance(FilterId{0}).as()).ldlt().solve(error)) / runs;
  }
  // χ² of 100 degrees of freedom, 99.9 %.
  CHECK(nees > 2 * 0.62);
  CHECK(nees < 2 * 1.49);
}

TEST_CASE("without recovery the filter stays locked out, and is lost") {
  const auto composition = composition_of(line("", gated + R"(, "recover": false)"));
  const Session session = run(composition, 5, [](double t, double z, Truth&) { return t < 300 ? z : z + 500; });
  INFO(said(session));
  CHECK(session.counts(MeasurementId{{0}, 0}).recoveries == 0);
  CHECK(session.verdict(FilterId{0}) != Verdict::ok);
}

TEST_CASE("samples that are withheld are no part of those of which most come late") {
  Session session(composition_of(line("", R"(, "withhold": {"every": 2})")));
  for (int i = 0; i < 100; ++i) push(session, "z", 0.5 * i, {1.0});
  for (int i = 0; i < 60; ++i) push(session, "z", 0.5 * i + 0.25, {1.0});
  const auto counts = session.counts(MeasurementId{{0}, 0});
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::late)] == 60);
  REQUIRE(counts.by_outcome[static_cast<int>(Outcome::withheld)] == 50);
  CHECK(has_code(session, "B102"));
}

namespace {

/// A speedometer that shows next to nothing, ten times a second for five minutes, and fixes from one time on, so often.
Session with_fixes(double from, double every) {
  Session session(composition_of(fix_and_speed(R"("sigma": [20])", R"("sigma": [50])")));
  double next = from;
  for (int i = 0; i < 3000; ++i) {
    push(session, "v", 0.1 * i, {50.0 * (i % 2 ? 1 : -1)});
    if (0.1 * i < next) continue;
    push(session, "z", 0.1 * i, {0.0});
    next += every;
  }
  return session;
}

}  // namespace

TEST_CASE("fixes that are missing from the start on are a doubt, and a slow sensor is none") {
  CHECK(has_code(with_fixes(1000, 1), "B117"));  // never
  CHECK(has_code(with_fixes(299, 1), "B117"));   // one, at the end
  CHECK(has_code(with_fixes(150, 1), "B117"));
  CHECK_FALSE(has_code(with_fixes(0, 1), "B117"));
  CHECK_FALSE(has_code(with_fixes(45, 45), "B117"));
}

TEST_CASE("a part that is mostly refused makes a filter lost, though others pass") {
  const auto verdict = [](double jump) {
    Session session(composition_of(R"({"binnacle": 1,
      "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m/s"}}}},
      "filters": {"f": {
        "blocks": {"position": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 2},
                   "velocity": {"type": "vector", "size": 2, "unit": "m/s", "init": [0, 0], "sigma": 0.3}},
        "process": {"stay": {"type": "random_walk", "blocks": {"x": "position"}, "q": 0.01},
                    "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.01}},
        "measurements": {"both": {"channel": "z", "gate": {"probability": 0.999, "by": "row"}, "recover": false, "stack": {
          "p": {"type": "linear_measurement", "blocks": {"x": "position"}, "sigma": [0.5]},
          "v": {"type": "linear_measurement", "blocks": {"x": "velocity"}, "fields": {"z0": "z1"}, "H": [[1, 0]], "sigma": [0.5]},
          "w": {"type": "linear_measurement", "blocks": {"x": "velocity"}, "fields": {"z0": "z1"}, "H": [[0, 1]], "sigma": [0.5]}
        }}}}}})"));
    for (int i = 0; i < 200; ++i)
      push(session, "z", i, {(i < 50 ? 0 : jump) + 0.1 * ((i * 7) % 11 - 5), 0.1 * ((i * 5) % 11 - 5)});
    return has_code(session, "B102") && session.verdict(FilterId{0}) == Verdict::lost;
  };
  CHECK(verdict(100));
  CHECK_FALSE(verdict(0));
}

TEST_CASE("a mean that is too small for a window is doubtful over ten minutes") {
  const auto composition = composition_of(line());
  int by_window = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    // A steady acceleration that the filter does not know: it lags behind, by less than the noise.
    const Session session = run(composition, seed, [](double t, double z, Truth&) { return z + 0.5 * 0.06 * t * t; });
    INFO(said(session));
    CHECK(session.verdict(FilterId{0}) == Verdict::doubtful);
    CHECK(has_code(session, "B104"));
    CHECK(session.counts(MeasurementId{{0}, 0}).rows.at(0).mean < 0.3);
    by_window += said(session).find("in the window from 0.0 s") == std::string::npos;
  }
  CHECK(by_window <= 3);
}

TEST_CASE("a mean up to what is systematic in a measurement is no reason, and beyond it is one") {
  const auto verdict = [](const std::string& systematic) {
    const auto composition = composition_of(line("", R"(, "systematic": )" + systematic));
    // The filter lags behind by 0.2 of its sigma.
    return run(composition, 3, [](double t, double z, Truth&) { return z + 0.5 * 0.06 * t * t; }).verdict(FilterId{0});
  };
  CHECK(verdict("0") == Verdict::doubtful);
  CHECK(verdict("0.02") == Verdict::doubtful);
  CHECK(verdict("0.3") == Verdict::ok);
  CHECK_THROWS_AS(verdict("-0.1"), ConfigError);
  CHECK_THROWS_AS(verdict(R"("0.1 m/s")"), ConfigError);
}

TEST_CASE("the limits can be changed and turned off") {
  const auto spoil = [](double, double z, Truth& truth) { return z + 1.0 * truth.normal(); };
  const auto with = [&](const std::string& trust) {
    std::string config = line();
    config.insert(config.find(R"("blocks")"), R"("trust": )" + trust + ", ");
    return run(composition_of(config), 1, spoil).verdict(FilterId{0});
  };
  CHECK(with("{}") == Verdict::doubtful);
  CHECK(with("false") == Verdict::ok);
  CHECK(with(R"({"except": "fix"})") == Verdict::ok);
  CHECK(with(R"({"nis": false, "bias": false, "correlation": false})") == Verdict::ok);
  CHECK(with(R"({"false_alarm": false})") == Verdict::ok);
  CHECK(with(R"({"beyond_reason": 1.2})") == Verdict::lost);
  CHECK_THROWS_AS(with(R"({"except": "fax"})"), ConfigError);
  CHECK_THROWS_AS(with(R"({"nees": false})"), ConfigError);
}

namespace {

void carry(Session& session, double t) {
  const double rate = 0;
  session.push(session.channel("v"), nanoseconds(t), nanoseconds(t + 0.1), {&rate, 1});
}

/// A position that is carried by a measured velocity, ten times a second for ten seconds.
Session carried() {
  Session session(composition_of(R"({"binnacle": 1,
    "sources": {"v": {"type": "pushed", "fields": {"v": {"unit": "m/s", "kind": "rate"}}},
                "z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"position": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1}},
      "process": {"go": {"type": "carried", "input": "v", "blocks": {"x": "position"}}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "position"}, "sigma": [1]}}}}})"));
  for (int i = 0; i < 100; ++i) carry(session, 0.1 * i);
  push(session, "z", 10, {0});
  return session;
}

}  // namespace

TEST_CASE("a hole that the filter bridges is a doubt with its place and length") {
  const auto with_hole = [](double length) {
    Session session = carried();
    carry(session, 10 + length);
    return session;
  };
  CHECK_FALSE(has_code(with_hole(0.4), "B108"));
  CHECK(has_code(with_hole(2), "B108"));
}

TEST_CASE("a filter whose input has ended is lost, and one sample labelled an hour ahead ends no input") {
  Session ended = carried();
  for (int i = 0; i < 45; ++i) {
    CHECK(ended.verdict(FilterId{0}) == (i <= 30 ? Verdict::ok : Verdict::lost));
    push(ended, "z", 11.0 + i, {0});
  }
  CHECK(said(ended) == "lost\nB118 the input of 'f' ended at 10.0 s, 45 s before the newest sample (limit 30 s)");
  carry(ended, 55);
  CHECK_FALSE(has_code(ended, "B118"));

  Session mislabelled = carried();
  push(mislabelled, "z", 3610, {0});
  for (int i = 0; i < 20; ++i) push(mislabelled, "z", 11.0 + i, {0});
  CHECK(mislabelled.verdict(FilterId{0}) == Verdict::ok);
}

}  // namespace trust_test
