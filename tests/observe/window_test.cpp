// SPDX-License-Identifier: Apache-2.0
// Windows along a step log of a constant with P = 1, seen by samples of R = 1: k samples leave 1/(k + 1).
#include "catch.hpp"

#include <vector>

#include "observe/observe.hpp"
#include "observe/window.hpp"

namespace window_test {

using namespace binnacle;
using observe::FilterWatch;
using observe::Stay;
using observe::Window;

namespace {

FilterInfo constant() {
  FilterInfo filter;
  filter.name = "f";
  filter.dof = 1;
  filter.blocks.resize(1);
  filter.blocks[0].active = {0};
  filter.measurements.resize(1);
  return filter;
}

ConstMatrixView scalar(const double& value) { return {&value, 1, 1, 1}; }

/// What a filter logs, by hand; one unit of time is a second.
struct Log {
  explicit Log(FilterWatch& watch) : to(watch) {}
  void start(double at, double variance = 1) {
    t = nanoseconds(at);
    P = variance;
    to.started(t, nullptr, scalar(P));
  }
  void step(double until) {
    StepRecord record;
    record.t0 = t;
    record.t1 = t = nanoseconds(until);
    record.P0 = scalar(P);
    record.P1 = scalar(other);
    record.Phi = scalar(one);
    record.Qd = scalar(zero);
    to.stepped(record);
  }
  void see(Outcome outcome = Outcome::accepted) {
    const std::int64_t key = 0;
    const int group = 0;
    UpdateRecord record;
    record.t = t;
    record.outcome = outcome;
    record.rows = 1;
    record.row_keys = &key;
    record.row_groups = &group;
    record.H = record.R = scalar(one);
    to.offered(record);
    if (outcome == Outcome::accepted) P = P / (P + 1);
  }
  FilterWatch& to;
  Time t = no_time;
  double P = 1;
  static constexpr double one = 1, zero = 0, other = 77;
};

Window window(double from, double to, bool is_relative = false) {
  return {"w", {nanoseconds(from), nanoseconds(to), is_relative, is_relative}};
}

double removed(const Stay& stay) { return stay.with_noise.removed()(0, 0); }

}  // namespace

TEST_CASE("a window begins with what the filter knew then, and counts what comes after") {
  const FilterInfo filter = constant();
  FilterWatch watch(filter, {observe::whole_run(), window(12, 14), window(2.5, 4, true), window(100, 200)});
  CHECK(includes(watch.wants(), Wants::step_covariance | Wants::transition | Wants::jacobian | Wants::reset));
  Log log(watch);
  log.start(10);
  log.see();  // at the start
  for (const double t : {11.0, 12.0, 13.0, 14.0, 15.0}) {
    log.step(t);
    log.see();
    log.see(Outcome::gated);
  }
  REQUIRE(watch.stays().size() == 3);
  const auto stays = watch.stays().begin();
  const Stay &whole = *stays, &later = *std::next(stays), &relative = *std::next(stays, 2);
  CHECK(whole.at_start);
  CHECK(whole.accepted.size() == 6);
  CHECK(removed(whole) == Approx(6.0 / 7));
  CHECK(whole.from == nanoseconds(10));
  CHECK(whole.to == nanoseconds(15));
  // After three samples, P is 1/4; two more leave 1/6 of 1, which is 2/3 of it.
  CHECK_FALSE(later.at_start);
  CHECK(later.from == nanoseconds(12));
  CHECK(later.to == nanoseconds(14));
  CHECK(later.P0(0, 0) == Approx(0.25));
  CHECK(later.accepted.size() == 2);
  CHECK(removed(later) == Approx(1.0 / 3));
  // From 12.5 s: the step that leads over it begins at 12 s.
  CHECK(relative.from == nanoseconds(12));
  CHECK(relative.accepted.size() == 2);
  REQUIRE(later.history.entries().size() == 2);
  CHECK(later.history.entries()[0].t == nanoseconds(13));
  CHECK(later.history.entries()[0].removed(0, 0) == Approx(0.2));
}

TEST_CASE("nothing is wanted of the log any more when the last window is over") {
  const FilterInfo filter = constant();
  FilterWatch watch(filter, {window(0, 2)});
  Log log(watch);
  log.start(0);
  log.step(1);
  CHECK(includes(watch.wants(), Wants::transition));
  CHECK_FALSE(includes(watch.wants(), Wants::step_covariance));
  log.step(3);
  CHECK(watch.wants() == Wants::nothing);
  log.see();
  CHECK(watch.stays().front().accepted.empty());
}

TEST_CASE("where the filter starts anew, windows end and go on as others") {
  const FilterInfo filter = constant();
  FilterWatch watch(filter, {observe::whole_run(), window(1, 2)});
  Log log(watch);
  log.start(0);
  for (const double t : {1.0, 2.0, 3.0}) {
    log.step(t);
    log.see();
  }
  log.start(3, 4);
  log.step(4);
  log.see();
  REQUIRE(watch.stays().size() == 3);
  const Stay &first = watch.stays().front(), &anew = watch.stays().back();
  CHECK(first.restarted);
  CHECK(removed(first) == Approx(0.75));
  CHECK(anew.name == "the whole run, from the new start");
  CHECK_FALSE(anew.restarted);
  CHECK(anew.from == nanoseconds(3));
  CHECK(removed(anew) == Approx(0.8));
  CHECK_FALSE(std::next(watch.stays().begin())->restarted);
}

TEST_CASE("what recovery opens is counted and shows nothing, named variances are noise") {
  const FilterInfo filter = constant();
  for (const bool is_named : {false, true}) {
    FilterWatch watch(filter, {observe::whole_run()});
    Log log(watch);
    log.start(0);
    const double three = 3;
    InflationRecord record;
    (is_named ? record.variances : record.scales) = &three;
    watch.inflated(record);
    log.see();
    CHECK(watch.stays().front().opened == 1);
    // Of r = e + w + v: 1/(1 + 3 + 1).
    CHECK(removed(watch.stays().front()) == Approx(is_named ? 0.2 : 0.5));
    CHECK(watch.stays().front().without_noise.removed()(0, 0) == Approx(0.5));
  }
}

}  // namespace window_test
