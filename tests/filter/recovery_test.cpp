// SPDX-License-Identifier: Apache-2.0
// Recovery: how far the covariance is opened, for which rows, and when; a mean that is wrong for long.
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "binnacle/eigen.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace recovery_test {

using namespace binnacle;

using filter_tests::composition_of;
using filter_tests::fix_and_speed;
using filter_tests::line;
using filter_tests::push;
using filter_tests::reason_of;
using filter_tests::receiver;

namespace {

/// What an observer sees of a filter of two states.
class Keep : public StepObserver {
 public:
  struct Opening {
    bool adds = false;
    Eigen::Vector2d figures;  // variances or scales
    Eigen::Matrix2d P0, P1;
  };
  Wants wants() const override { return Wants::everything; }
  void offered(const UpdateRecord& record) override {
    nis = record.nis;
    outcome = record.outcome;
    if (record.outcome == Outcome::accepted) delta = Eigen::Map<const Eigen::Vector2d>(record.delta);
  }
  void inflated(const InflationRecord& record) override {
    const double* const figures = record.variances ? record.variances : record.scales;
    openings.push_back(
        {record.variances != nullptr, Eigen::Map<const Eigen::Vector2d>(figures), record.P0.as(), record.P1.as()});
  }
  double nis = 0;
  Outcome outcome = Outcome::late;
  Eigen::Vector2d delta;
  std::vector<Opening> openings;
};

MeasurementCounts counts(const Session& session, int measurement = 0) {
  return session.counts(MeasurementId{{0}, measurement});
}

std::vector<std::byte> bytes_of(const Session& session) {
  std::vector<std::byte> bytes(session.snapshot_size());
  session.snapshot(bytes);
  return bytes;
}

/// Position by itself and velocity by itself, each a measurement; the position has a gate.
std::string two_witnesses(const std::string& position_extra, const std::string& velocity_extra = "") {
  return fix_and_speed(R"("sigma": [0.5])" + position_extra, R"("sigma": [0.01])" + velocity_extra);
}

/// Within 0.5, without a mean.
double wiggle_of(int i) { return 0.1 * ((i * 7) % 11 - 5); }

/// It stands at zero; from 60 s on the speedometer shows `offset`. Ten fixes a second.
Session with_wrong_speed(const std::string& config, double offset, double until) {
  Session session(composition_of(config));
  for (int i = 0; 0.1 * i < until; ++i) {
    push(session, "v", 0.1 * i, {0.1 * i < 60 ? 0.0 : offset});
    push(session, "z", 0.1 * i, {wiggle_of(i)});
  }
  return session;
}

/// By a verdict of its own what a recovery is worth; ok where there was none.
Verdict of_recovery(const Session& session) {
  const auto reason = reason_of(session, Doubt::recovered);
  return reason ? reason->verdict : Verdict::ok;
}

}  // namespace

TEST_CASE("recovery opens along what the row sees, as far as its residual asks for") {
  Session session(composition_of(line("", R"(, "gate": 0.999)")));
  for (int i = 0; i < 200; ++i) push(session, "z", 0.5 * i, {1.0});
  Keep keep;
  session.attach({0}, &keep);
  for (int i = 200; i < 204; ++i) {
    push(session, "z", 0.5 * i, {101.0});
    CHECK(keep.outcome == Outcome::gated);
    CHECK(keep.openings.empty());
  }
  push(session, "z", 0.5 * 204, {101.0});
  CHECK(keep.outcome == Outcome::accepted);
  REQUIRE(keep.openings.size() == 3);

  // As far as a right sample would have it: one row, NIS 1.
  const auto& along = keep.openings[0];
  REQUIRE_FALSE(along.adds);
  const Eigen::Matrix2d D = along.figures.asDiagonal();
  CHECK((along.P1 - D * along.P0 * D).norm() < 1e-12 * along.P1.norm());
  const double S = along.P1(0, 0) + 0.7 * 0.7;
  CHECK(std::abs(keep.nis * (S + 4) / S - 1) < 1e-9);
  // Through the correlation the velocity opens in proportion.
  const Eigen::Vector2d more = (along.P1 - along.P0).diagonal();
  CHECK(std::abs(std::sqrt(more[1] / more[0]) - along.P0(1, 0) / along.P0(0, 0)) < 1e-9);
  CHECK(std::sqrt(more[0]) > 50);

  // What was learnt in the wrong place: the variances of the start.
  const auto& unlearnt = keep.openings[1];
  REQUIRE(unlearnt.adds);
  CHECK((unlearnt.figures - Eigen::Vector2d(4, 0.09)).norm() < 1e-12);
  const Eigen::Matrix2d with_start = unlearnt.P0 + Eigen::Matrix2d(unlearnt.figures.asDiagonal());
  CHECK((unlearnt.P1 - with_start).norm() < 1e-12 * with_start.norm());

  // And a tenth of the correction, which was linearized far off.
  const auto& left = keep.openings[2];
  REQUIRE_FALSE(left.adds);
  const Eigen::Vector2d kept = left.P0.diagonal() + 0.01 * keep.delta.cwiseAbs2();
  CHECK((left.P1.diagonal() - kept).norm() < 1e-12 * kept.norm());
  CHECK(std::abs(left.P1(0, 1) / std::sqrt(left.P1(0, 0) * left.P1(1, 1)) -
                 left.P0(0, 1) / std::sqrt(left.P0(0, 0) * left.P0(1, 1))) < 1e-12);
}

TEST_CASE("recovery opens no component beyond what it has when nothing is known of it") {
  // A correlated error of the receiver, 0.5 m and no more, is seen with the position.
  const auto composition = composition_of(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}},
                "vague": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 2, "unit": "m", "sigma": [2, 0.5]}},
      "process": {"drift": {"type": "gauss_markov", "blocks": {"x": "x"}, "tau": ["1000000 s", "20 s"], "sigma": [1000, 0.5]}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "H": [[1, 1]],
                               "sigma": [0.7], "gate": 0.999},
        "nothing": {"type": "linear_measurement", "channel": "vague", "blocks": {"x": "x"}, "H": [[1, 1]],
                    "sigma": [1e6]}}}}})");
  Session session(composition);
  for (int i = 0; i < 200; ++i) push(session, "z", 0.5 * i, {0.0});
  for (int i = 200; i < 204; ++i) push(session, "z", 0.5 * i, {100.0});
  // Nor does a filter that was restored since its last step: what bounds it is part of a snapshot.
  push(session, "vague", 0.5 * 204, {0.0});
  Session restored(composition);
  restored.restore(bytes_of(session));
  for (Session* each : {&session, &restored}) push(*each, "z", 0.5 * 204, {100.0});
  REQUIRE(counts(session).recoveries == 1);
  CHECK(bytes_of(session) == bytes_of(restored));
  const auto x = session.state(FilterId{0});
  CHECK(std::abs(x[0] - 100) < 3);
  CHECK(std::abs(x[1]) < 2);
  CHECK(std::sqrt(session.covariance(FilterId{0}).as()(1, 1)) < 0.51);
}

TEST_CASE("rows that pass and whose mean is wrong for long are believed in the end") {
  const std::string gate = R"(, "gate": 0.9999)";
  // 0.05 m/s, five sigma, pull the position away, and the gate does not mind.
  const Session before = with_wrong_speed(two_witnesses(gate, gate), 0.05, 100);
  CHECK(counts(before).by_outcome[static_cast<int>(Outcome::gated)] == 0);
  CHECK(counts(before).recoveries == 0);  // the speed contradicts, and it is not 45 s yet
  const double pulled = before.state(FilterId{0})[0];
  CHECK(pulled > 0.4);

  const Session after = with_wrong_speed(two_witnesses(gate, gate), 0.05, 125);
  CHECK(counts(after).recoveries >= 1);
  CHECK(after.verdict(FilterId{0}) == Verdict::doubtful);

  const Session off = with_wrong_speed(two_witnesses(gate + R"(, "recover": false)", gate), 0.05, 125);
  CHECK(counts(off).recoveries == 0);
}

TEST_CASE("rows that were wrong for long are believed at once when it has been long enough") {
  // The window from 70.7 s on is over at 80.8 s, the next at 90.9 s; it has been 13 s at 83.7 s.
  const std::string gate = R"(, "gate": 0.9999)";
  Session session(composition_of(two_witnesses(gate + R"(, "recover": {"against": "13 s"})", gate)));
  Keep keep;
  session.attach({0}, &keep);
  const auto drive = [&](int from, int end) {
    for (int i = from; i < end; ++i) {
      push(session, "v", 0.1 * i, {i < 600 ? 0.0 : 0.09});
      push(session, "z", 0.1 * i, {wiggle_of(i)});
    }
  };
  drive(0, 830);
  CHECK(keep.openings.empty());
  drive(830, 840);
  CHECK(keep.openings.size() == 1);
  CHECK(counts(session).recoveries == 1);
}

TEST_CASE("a wrong state starts anew at once where the channel that it would start from contradicts it") {
  // Position by fixes, and by another sensor that only gives first values.
  const auto starts_anew_after = [](double seen) {
    Session session(composition_of(R"({"binnacle": 1,
      "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}},
                  "other": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
      "filters": {"f": {
        "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "sigma": 2,
                         "init": {"channel": "other", "fields": {"x": "z0"}, "max_age": "2 s", "again": true}}},
        "process": {"stay": {"type": "random_walk", "blocks": {"x": "x"}, "q": 0.01}},
        "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [0.7],
                                 "gate": 0.999}}}}})"));
    for (int i = 0; i < 120; ++i) {
      push(session, "other", i, {i < 100 ? 0.0 : seen});
      push(session, "z", i, {(i < 100 ? 0.0 : 100.0) + wiggle_of(i)});
    }
    CHECK(counts(session).recoveries == 1);
    CHECK(std::abs(session.state(FilterId{0})[0] - 100) < 2);
    const auto restarted = reason_of(session, Doubt::restarted);
    return restarted ? restarted->since : no_time;
  };
  CHECK(starts_anew_after(0) == no_time);
  CHECK(starts_anew_after(100) == nanoseconds(104.0));
}

TEST_CASE("a first value that the block refuses contradicts nothing") {
  Session session(composition_of(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"}}},
                "other": {"type": "pushed", "fields": {"lat": {"unit": "rad"}, "lon": {"unit": "rad"}, "height": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"p": {"type": "position", "sigma": "2 m", "init": {"channel": "other", "max_age": "2 s", "again": true}}},
      "process": {"stay": {"type": "random_constant", "blocks": {"x": "p"}}},
      "measurements": {"fix": {"type": "position_fix", "channel": "z", "blocks": {"position": "p"}, "sigma": "0.7 m",
                               "gate": 0.999}}}}})"));
  constexpr double beyond_a_pole = 2, hundred_metres = 100 / 6.37e6;
  for (int i = 0; i < 120; ++i) {
    push(session, "other", i, {i < 100 ? 0.8 : beyond_a_pole, 0.2, 0});
    push(session, "z", i, {i < 100 ? 0.8 : 0.8 + hundred_metres, 0.2, 0});
  }
  CHECK(session.diagnosis(FilterId{0}) == "");
  CHECK(counts(session).recoveries == 1);
  CHECK(std::abs(session.state(FilterId{0})[0] - 0.8 - hundred_metres) < 0.02 * hundred_metres);
}

TEST_CASE("what no gate can refuse is no witness for the state") {
  // All that could refuse is refused: the state is wrong, whatever passes without a gate.
  const auto jump = [](const std::string& of_speed) {
    Session session(composition_of(two_witnesses(R"(, "gate": 0.999)", of_speed)));
    for (int i = 0; i < 100; ++i) {
      push(session, "v", i, {0.0});
      push(session, "z", i, {i < 50 ? 0.0 : 100.0});
    }
    return counts(session).by_outcome[static_cast<int>(Outcome::gated)];
  };
  CHECK(jump("") < 10);
  CHECK(jump(R"(, "gate": 0.999)") > 40);
}

TEST_CASE("a jump that nothing confirms is lost: a frozen position beside a living speed") {
  const std::string gate = R"(, "gate": 0.999)";
  const auto jump = [&](double position, double speed, bool is_missing_before) {
    Session session(composition_of(fix_and_speed(R"("sigma": [0.5])" + gate, R"("sigma": [0.1])" + gate)));
    for (int i = 0; i < 200; ++i) {
      push(session, "v", i, {(i < 100 ? 0.0 : speed) + 0.1 * wiggle_of(i)});
      if (!is_missing_before || i < 50 || i >= 100)
        push(session, "z", i, {(i < 100 ? 0.0 : position + speed * (i - 100)) + wiggle_of(i)});
    }
    REQUIRE(counts(session).recoveries >= 1);
    return of_recovery(session);
  };
  CHECK(jump(300, 0, false) == Verdict::lost);
  CHECK(jump(3000, 0, false) == Verdict::lost);
  CHECK(jump(300, 0, true) == Verdict::doubtful);   // as after a tunnel
  CHECK(jump(300, 4, false) == Verdict::doubtful);  // the speedometer contradicts the state too
}

TEST_CASE("two parts of a sample confirm each other, but not what no error that grew can be") {
  const auto jump = [](double position, double speed) {
    Session session(composition_of(receiver(R"("gate": {"probability": 0.9999, "by": "row"}, )", 0.5, 0.01)));
    for (int i = 0; i < 200; ++i)
      push(session, "z", i,
           {(i < 100 ? 0.0 : position + speed * (i - 100)) + wiggle_of(i),
            (i < 100 ? 0.0 : speed) + 0.1 * wiggle_of(i)});
    REQUIRE(counts(session).recoveries >= 1);
    return of_recovery(session);
  };
  CHECK(jump(40, 10) == Verdict::doubtful);
  CHECK(jump(300, 0) == Verdict::lost);
  CHECK(jump(7e6, 10) == Verdict::lost);
}

TEST_CASE("a sample that repeats refused ones to the bit is refused, though the state may have come near") {
  Session session(composition_of(line("", R"(, "gate": 0.999)")));
  const auto wiggle = [](int i) { return 0.01 * ((i * 7) % 11 - 5); };
  for (int i = 0; i < 100; ++i) push(session, "z", i, {1 + wiggle(i)});
  for (int i = 100; i < 160; ++i) push(session, "z", i, {500.0});  // it hangs
  const auto hanging = counts(session);
  // The first is no repetition.
  CHECK(hanging.by_outcome[static_cast<int>(Outcome::gated)] == 60);
  CHECK(hanging.recoveries == 0);
  CHECK(hanging.last_reason == "it repeats refused samples to the bit");
  CHECK(session.verdict(FilterId{0}) == Verdict::lost);
  for (int i = 160; i < 170; ++i) push(session, "z", i, {1 + wiggle(i)});
  CHECK(counts(session).by_outcome[static_cast<int>(Outcome::accepted)] > 100);
}

TEST_CASE("a gate by row refuses a row once a sample, and recovers after as many as the config says") {
  for (const int after : {2, 4, 5}) {
    Session session(composition_of(line("", R"(, "gate": {"probability": 0.999, "by": "row"}, "recover": {"after": )" +
                                                std::to_string(after) + "}")));
    for (int i = 0; i < 100; ++i) push(session, "z", 0.5 * i, {i < 50 ? 1.0 : 101.0});
    INFO(after);
    CHECK(counts(session).by_outcome[static_cast<int>(Outcome::gated)] == after - 1);
    CHECK(counts(session).rows.at(0).refused == after - 1);
  }
}

TEST_CASE("a logger that holds its values is recovered by those that change") {
  Session session(composition_of(line("", R"(, "gate": 0.999)")));
  for (int i = 0; i < 2000; ++i) {
    const int second = i / 10;
    push(session, "z", 0.1 * i, {(second < 100 ? 1.0 : 101.0) + 0.01 * ((second * 7) % 11 - 5)});
  }
  CHECK(counts(session).recoveries >= 1);
  CHECK(std::abs(session.state(FilterId{0})[0] - 101) < 2);
  CHECK(of_recovery(session) == Verdict::lost);  // nothing else confirms it
}

TEST_CASE("a state that is known far better than it is measured is opened too, and that is counted") {
  Session session(composition_of(R"({"binnacle": 1,
    "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {
      "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 2}},
      "process": {"stay": {"type": "random_constant", "blocks": {"x": "x"}}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [0.7],
                               "gate": 0.999}}}}})"));
  for (int i = 0; i < 20000; ++i) push(session, "z", i, {wiggle_of(i)});
  for (int i = 20000; i < 20100; ++i) push(session, "z", i, {8.4 + wiggle_of(i)});
  CHECK(counts(session).recoveries == 1);
  CHECK(of_recovery(session) == Verdict::lost);
  CHECK(std::abs(session.state(FilterId{0})[0] - 8.4) < 0.3);
}

}  // namespace recovery_test
