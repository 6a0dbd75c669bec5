// SPDX-License-Identifier: Apache-2.0
TEST_@CASE("one; two", "[tag]") {}  // bad
TEST_@CASE("one, two", "[tag]") {}
TEST_@CASE_METHOD(Fixture, "three; four") {}  // bad
void one() { SECTION("five; six"); }
