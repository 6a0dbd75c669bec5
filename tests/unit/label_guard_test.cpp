// SPDX-License-Identifier: Apache-2.0
// Labels far ahead: one is left out, a clock that jumps is followed, and a source that was silent is believed.
#include "line_input/label_guard.hpp"
#include "catch.hpp"

namespace label_guard_test {

using namespace binnacle;

namespace {

constexpr Time s = nanoseconds_per_second;

/// 10 Hz, from 0 s to 10 s, as they come.
line_input::LabelGuard after_ten_seconds() {
  line_input::LabelGuard guard(10 * s);
  for (Time t = 0; t <= 10 * s; t += s / 10) REQUIRE(guard.accepts(t, t));
  return guard;
}

}  // namespace

TEST_CASE("labels far ahead are left out until they go on for 3 s") {
  auto guard = after_ten_seconds();
  const Time arrival = 10 * s;
  for (Time t = 0; t < 3 * s; t += s / 10) CHECK_FALSE(guard.accepts(3610 * s + t, arrival));
  CHECK(guard.accepts(10 * s + s / 10, arrival));  // among them: they were wrong
  CHECK_FALSE(guard.is_anew());
  for (Time t = 0; t < 3 * s; t += s / 10) CHECK_FALSE(guard.accepts(3610 * s + t, arrival));
  CHECK(guard.accepts(3613 * s, arrival));
  CHECK(guard.is_anew());
  CHECK(guard.accepts(3613 * s + 1, arrival));
  CHECK_FALSE(guard.is_anew());
}

TEST_CASE("few labels a minute apart are a jump once they are four, and labels that do not go on are none") {
  auto guard = after_ten_seconds();
  for (int i = 0; i < 3; ++i) CHECK_FALSE(guard.accepts(3600 * s + i * 9 * s, 10 * s));
  CHECK(guard.accepts(3600 * s + 27 * s, 10 * s));
  auto other = after_ten_seconds();
  for (int i = 1; i < 50; ++i) CHECK_FALSE(other.accepts(i * 3600 * s, 10 * s));
}

TEST_CASE("a step of up to max_ahead, and one as long as the source was silent, are no jump") {
  auto guard = after_ten_seconds();
  CHECK(guard.accepts(20 * s, 10 * s));
  CHECK_FALSE(guard.accepts(30 * s + 1, 10 * s));
  CHECK(guard.accepts(80 * s, 40 * s));
  CHECK_FALSE(guard.is_anew());
}

TEST_CASE("labels far behind pass, and if they go on the one ahead of them was wrong") {
  line_input::LabelGuard guard(10 * s);
  REQUIRE(guard.accepts(3600 * s, 0));
  for (Time t = 0; t < 3 * s; t += s / 10) {
    CHECK(guard.accepts(t, t));
    CHECK_FALSE(guard.is_anew());
  }
  CHECK(guard.accepts(3 * s, 3 * s));
  CHECK(guard.is_anew());
  CHECK_FALSE(guard.accepts(3600 * s, 3 * s));
}

}  // namespace label_guard_test
