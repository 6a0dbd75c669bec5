// SPDX-License-Identifier: Apache-2.0
// Starting anew: after recoveries in vain, and after a hole that is too long to bridge.
#include <algorithm>
#include <string>
#include <vector>

#include "binnacle/eigen.hpp"
#include "catch.hpp"
#include "line.hpp"

namespace restart_test {

using namespace binnacle;

using filter_tests::composition_of;
using filter_tests::push;
using filter_tests::reason_of;

namespace {

constexpr const char* again = R"("init": {"channel": "first", "fields": {"x": "z0"}, "again": true}, "sigma": 2)";

/// A position that is carried by a measured velocity, from a channel's first value on.
std::string carried(const std::string& start = again, const std::string& keys = "") {
  return R"({"binnacle": 1,
    "sources": {"v": {"type": "pushed", "fields": {"v": {"unit": "m/s", "kind": "rate"}}},
                "first": {"type": "pushed", "fields": {"z0": {"unit": "m"}}},
                "other": {"type": "pushed", "fields": {"x": {"unit": "m"}}},
                "z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
    "filters": {"f": {)" +
         keys + R"("blocks": {"position": {"type": "vector", "size": 1, "unit": "m", )" + start + R"(}},
      "process": {"go": {"type": "carried", "input": "v", "blocks": {"x": "position"}}},
      "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "position"}, "sigma": [1],
                               "gate": 0.999}}}}})";
}

/// Steps of 0.1 s without motion.
void drive(Session& session, double from, double to) {
  const double rate = 0;
  for (int i = 0; from + 0.1 * (i + 0.5) < to; ++i)
    session.push(session.channel("v"), nanoseconds(from + 0.1 * i), nanoseconds(from + 0.1 * (i + 1)), {&rate, 1});
}

bool has_code(const Session& session, const std::string& code) {
  const Diagnostics doubts = session.doubts(FilterId{0});
  const auto& items = doubts.items();
  return std::ranges::any_of(items, [&](const Diagnostic& item) { return item.code == code; });
}

double position(const Session& session) { return session.state(FilterId{0})[0]; }
double variance(const Session& session) { return session.covariance(FilterId{0}).as()(0, 0); }

/// Three recoveries: each time the measured position is elsewhere, before the last has settled.
void recover_in_vain(Session& session, double from) {
  for (int jump = 1; jump <= 3; ++jump)
    for (int i = 0; i < 5; ++i) {
      const double t = from + 5 * (jump - 1) + i;
      drive(session, t, t + 1);
      push(session, "z", t + 1, {1000.0 * jump});
    }
}

}  // namespace

TEST_CASE(
    "recovery that is in vain three times makes the filter start anew from the channel that gave its first value") {
  Session session(composition_of(carried()));
  push(session, "first", 0, {5});
  REQUIRE(session.started(FilterId{0}));
  recover_in_vain(session, 0);
  REQUIRE(session.counts(MeasurementId{{0}, 0}).recoveries == 3);
  CHECK_FALSE(has_code(session, "B115"));  // no new value yet
  CHECK(position(session) > 2000);
  push(session, "first", 15, {7});
  CHECK(position(session) == 7);
  CHECK(variance(session) == 4);
  CHECK(has_code(session, "B115"));
  CHECK(session.verdict(FilterId{0}) != Verdict::ok);
  // It goes on.
  drive(session, 15, 16);
  push(session, "z", 16, {7.5});
  CHECK(session.counts(MeasurementId{{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] > 0);
  CHECK(position(session) > 7);
  // A further value does not disturb it.
  push(session, "first", 16, {99});
  CHECK(position(session) < 8);
}

TEST_CASE("a value that came before the recoveries, or long after, does not start the filter anew") {
  Session session(composition_of(carried()));
  push(session, "first", 0, {5});
  recover_in_vain(session, 0);
  drive(session, 15, 70);
  push(session, "first", 70, {7});
  CHECK_FALSE(has_code(session, "B115"));
}

TEST_CASE("without \"again\" recovery goes on") {
  Session session(composition_of(carried(R"("init": {"channel": "first", "fields": {"x": "z0"}}, "sigma": 2)")));
  push(session, "first", 0, {5});
  recover_in_vain(session, 0);
  REQUIRE(session.counts(MeasurementId{{0}, 0}).recoveries == 3);
  push(session, "first", 15, {7});
  CHECK(position(session) > 2000);
  CHECK_FALSE(has_code(session, "B115"));
}

TEST_CASE("the filter may start anew from another channel than the first time") {
  Session session(composition_of(
      carried(R"("init": {"channel": "first", "fields": {"x": "z0"}, "again": {"channel": "other"}}, "sigma": 2)")));
  push(session, "first", 0, {5});
  REQUIRE(session.started(FilterId{0}));
  CHECK(position(session) == 5);
  recover_in_vain(session, 0);
  push(session, "first", 15, {7});
  CHECK(position(session) > 2000);
  push(session, "other", 15, {-3});
  CHECK(position(session) == -3);
}

TEST_CASE("a hole longer than longest_bridge stops the filter until it can start anew") {
  Session session(composition_of(carried(again, R"("longest_bridge": "3 s", )")));
  push(session, "first", 0, {5});
  drive(session, 0, 10);
  drive(session, 12, 13);  // bridged
  CHECK_FALSE(has_code(session, "B116"));
  drive(session, 20, 21);
  CHECK(session.verdict(FilterId{0}) == Verdict::lost);
  CHECK(has_code(session, "B116"));
  push(session, "z", 21, {5});
  CHECK(session.counts(MeasurementId{{0}, 0}).before_start == 1);
  push(session, "first", 21, {8});
  CHECK(position(session) == 8);
  CHECK_FALSE(has_code(session, "B116"));
  CHECK(has_code(session, "B108"));
  CHECK(has_code(session, "B115"));
  // The hole is why: no estimate before it was wrong.
  const auto restarted = [&] { return reason_of(session, Doubt::restarted).value(); };
  CHECK(restarted().limit == 7);
  drive(session, 21, 22);
  push(session, "z", 22, {8});
  CHECK(session.counts(MeasurementId{{0}, 0}).by_outcome[static_cast<int>(Outcome::accepted)] == 1);
  recover_in_vain(session, 22);
  push(session, "first", 37, {7});
  CHECK(restarted().figure == 2);
  CHECK(restarted().limit == 0);
}

TEST_CASE("what can not start anew is refused") {
  const auto load = [](const std::string& start, const std::string& keys = "") {
    return composition_of(carried(start, keys));
  };
  CHECK_THROWS_AS(load(R"("init": 5, "sigma": 2)", R"("longest_bridge": "3 s", )"), ConfigError);
  CHECK_THROWS_AS(load(R"("init": {"x": 5, "again": true}, "sigma": 2)"), ConfigError);
  CHECK_THROWS_AS(load(R"("init": {"channel": "first", "again": {"fields": {"x": "z0"}}}, "sigma": 2)"), ConfigError);
}

}  // namespace restart_test
