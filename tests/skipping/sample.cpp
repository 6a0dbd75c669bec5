// SPDX-License-Identifier: Apache-2.0
// Tests that end as BINNACLE_SAMPLE says; without it they pass.
#include <cstdlib>
#include <filesystem>
#include <string>

#include "catch.hpp"
#include "skip.hpp"

namespace {

bool is_asked_for(const std::string& what) {
  const char* sample = std::getenv("BINNACLE_SAMPLE");
  return sample && sample == what;
}

}  // namespace

TEST_CASE("one that skips") {
  CHECK(std::getenv("BINNACLE_SAMPLE_LEFT") == nullptr);
  if (is_asked_for("skip")) return binnacle::test::skip("as BINNACLE_SAMPLE asked");
  CHECK_FALSE(is_asked_for("fail"));
}

TEST_CASE("one that fails, then skips") {
  // As many checks as v3's exit status for "all were skipped".
  for (int check = 0; check < 4; ++check) CHECK_FALSE(is_asked_for("fail then skip"));
  if (is_asked_for("fail then skip")) return binnacle::test::skip("though a check has failed");
}

TEST_CASE("one that fails as often as 77") {
  for (int check = 0; check < 77; ++check) CHECK_FALSE(is_asked_for("77"));
}

// Each case begins with the environment and the working folder of the process, however often and in which order they run.
TEST_CASE("one that leaves something behind") {
  CHECK(std::getenv("BINNACLE_SAMPLE_LEFT") == nullptr);
  CHECK(std::filesystem::current_path() != "/");
  ::setenv("BINNACLE_SAMPLE_LEFT", "1", 1);
  std::filesystem::current_path("/");
}

TEST_CASE("one that would find it") {
  CHECK(std::getenv("BINNACLE_SAMPLE_LEFT") == nullptr);
  CHECK(std::filesystem::current_path() != "/");
}
