// SPDX-License-Identifier: Apache-2.0
// Mistakes in a config are named at their places: those that no test of the part itself makes.
#include <string>

#include "catch.hpp"
#include "command.hpp"

namespace refused_test {

using namespace binnacle::test;

namespace {

/// `check` of the quickstart with this change refuses it with these words.
void refuses(const std::string& set, const std::string& words) {
  const Workbench bench;
  const auto outcome =
      binnacle::test::binnacle(bench, {"check", BINNACLE_TEST_PROJECT "/configs/quickstart.json", "--set", set});
  INFO(outcome.err);
  CHECK(outcome.status == 3);
  CHECK(outcome.err.find(words) != std::string::npos);
}

}  // namespace

TEST_CASE("mistakes in a reference and in an initial value are named at their places") {
  refuses(R"(/reference/0/chanel="drive")",
          "error[B012] /reference/0/chanel: unknown key of a reference; did you mean 'channel'?");
  refuses("/filters/ins/blocks/position/init=3",
          "error[B006] /filters/ins/blocks/position/init: the initial value of block 'position' is an object with lat, "
          "lon, height");
}

}  // namespace refused_test
