// SPDX-License-Identifier: Apache-2.0
// What `check`, `explain` and `run` warn of before anything has gone wrong.
#include "catch.hpp"

#include <string>
#include <vector>

#include "command.hpp"

namespace early_warnings_test {

using namespace binnacle::test;

namespace {

const std::string configs = BINNACLE_TEST_PROJECT "/configs/";

/// What a verb prints to stderr of a config of the project, changed by `sets`.
std::string warned(const char* verb, const std::string& config, const std::vector<std::string>& sets) {
  const Workbench bench;
  std::vector<std::string> arguments{verb, configs + config};
  for (const auto& set : sets) arguments.insert(arguments.end(), {"--set", set});
  const auto outcome = binnacle::test::binnacle(bench, arguments);
  CHECK(outcome.status == 0);
  return outcome.err;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a number in a unit that was forgotten is a warning of check and explain") {
  for (const char* verb : {"check", "explain"}) {
    CHECK(warned(verb, "quickstart.json", {}).empty());
    const auto text = warned(verb, "quickstart.json", {"/filters/ins/process/strapdown/gyro_noise=0.5"});
    INFO(text);
    CHECK(has(text, "warning[B111] /filters/ins/process/strapdown/gyro_noise: 'gyro_noise' is 0.5 rad/sqrt(s)"));
    CHECK(has(text, "did you mean \"0.5 deg/sqrt(h)\"?"));
  }
  const auto text =
      warned("check", "quickstart.json", {"/filters/ins/measurements/fix/stack/position/sigma=[1500, 1500, 3000]"});
  INFO(text);
  CHECK(has(text, "warning[B111] /filters/ins/measurements/fix/stack/position/sigma/0: 'sigma' is 1500 m"));
}

TEST_CASE("a filter without any aiding of position is a warning, by what its measurements see") {
  const std::string code = "warning[B112] /filters/ins/blocks/position: filter 'ins' has no aiding of position";
  // By the velocity alone, and by nothing at all.
  for (const char* set : {"/filters/ins/measurements/fix/stack/position=null", "/filters/ins/measurements=null"}) {
    const auto text = warned("check", "quickstart.json", {set});
    INFO(text);
    CHECK(has(text, code));
    CHECK(has(text, "no measurement observes 'position', the integral of 'velocity'"));
  }
  CHECK(has(warned("check", "land/base.json", {}), code));
  // Its position is seen; it has none that moves; it is no position.
  for (const char* aided : {"quickstart.json", "transfer_alignment/base.json", "ship_motion/base.json"})
    CHECK_FALSE(has(warned("check", aided, {}), "B112"));
}

TEST_CASE("a gate without recovery is a warning") {
  const auto text = warned("check", "quickstart.json", {"/filters/ins/measurements/fix/recover=false"});
  INFO(text);
  CHECK(has(text, "warning[B113] /filters/ins/measurements/fix/recover: the gate of 'fix' has no recovery"));
  const std::string gate = "/filters/ins/measurements/fix/gate=null";
  CHECK_FALSE(has(warned("check", "quickstart.json", {"/filters/ins/measurements/fix/recover=false", gate}), "B113"));
}

}  // namespace early_warnings_test
