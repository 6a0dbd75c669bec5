// SPDX-License-Identifier: Apache-2.0
// configs/aiding, variants: heading, course and attitude_fix show where a car on a straight road looks, differences of arrival
// hold a place as ranges do; and each filter knows how wrong it is. Seeds and runs are those of the configs.
#include <cstdio>
#include <string>

#include "../papers/study_of.hpp"
#include "catch.hpp"

namespace aiding_variants_test {

namespace {

/// NEES and NIS of a variant lie in the bands of 99 % that the study states. Returns how many there were.
int check_bands(const nlohmann::ordered_json& study, const std::string& variant) {
  int count = 0;
  for (const auto& [name, metric] : study.at("variants").at(variant).at("metrics").items()) {
    if (!metric.contains("band")) continue;
    const double mean = metric.at("mean"), low = metric.at("band")[0], high = metric.at("band")[1];
    CAPTURE(variant, name, mean, low, high);
    CHECK(mean > low);
    CHECK(mean < high);
    ++count;
  }
  return count;
}

}  // namespace

TEST_CASE("a car on a straight road: two antennas, another system, wheels and a course each bring the heading") {
  const auto study = papers::summary_of("study", "aiding/car.json", "--jobs 2 --quiet");
  const auto degrees = [&](const char* variant, const char* error) {
    const double rms = papers::over_runs(study, variant, std::string("ins/attitude.") + error + "/rms", "rms");
    std::printf("%s, %s: %.4f deg\n", variant, error, rms);
    return rms;
  };
  for (const auto& [variant, bands] :
       {std::pair{"GNSS", 4}, {"two antennas", 5}, {"second system", 5}, {"wheels", 5}, {"wheels and course", 6}})
    CHECK(check_bands(study, variant) == bands);
  const double gnss = degrees("GNSS", "down"), wheels = degrees("wheels", "down");
  CHECK(degrees("two antennas", "down") < gnss / 10);
  CHECK(degrees("second system", "down") < gnss / 10);
  CHECK(degrees("second system", "tilt") < degrees("GNSS", "tilt") / 4);
  CHECK(wheels < gnss / 10);
  CHECK(degrees("wheels and course", "down") < 0.75 * wheels);
}

TEST_CASE("ten minutes without GNSS: differences of arrival in place of ranges") {
  std::string options = "--jobs 2 --quiet --set /study/table=null --set /study/variants/all=null";
  for (const char* sensor : {"magnetometer", "barometer", "DVL", "UWB", "UWB and barometer"})
    options += std::string(" --set '/study/variants/without ") + sensor + "=null'";
  const auto study = papers::summary_of("study", "aiding/ins.json", options);
  const char* const variant = "UWB by differences";
  for (const char* instant : {"120 s", "240 s", "360 s", "480 s", "600 s"}) {
    const auto& nees = study.at("variants").at(variant).at("metrics").at(std::string("ins/state/nees at ") + instant);
    const double mean = nees.at("mean"), low = nees.at("band")[0], high = nees.at("band")[1];
    CAPTURE(instant, mean);
    CHECK(mean > low);
    CHECK(mean < high);
  }
  const auto& nis = study.at("variants").at(variant).at("metrics").at("ins/uwb/nis");
  CHECK(nis.at("dof") == 3);
  CHECK(nis.at("mean") > nis.at("band")[0]);
  CHECK(nis.at("mean") < nis.at("band")[1]);
}

}  // namespace aiding_variants_test
