// SPDX-License-Identifier: Apache-2.0
// configs/aiding/at-rest.json: after half an hour at rest an INS knows how badly it knows its heading, with either error
// model; with what is said to be wrong there it does not. Independent: shared/oracles/heading_at_rest.py has 13.65 deg.
#include <cmath>
#include <string>

#include <boost/math/distributions/chi_squared.hpp>

#include "../papers/study_of.hpp"
#include "catch.hpp"

namespace at_rest_test {

namespace {

constexpr int runs = 40, dof = 3;
constexpr double possible = 13.65;  // deg, along the truth
const char* const nees = "ins/attitude/nees at 1800 s";
const char* const sigma = "ins/attitude.yaw/sigma";

}  // namespace

TEST_CASE("at rest: the heading's sigma is that along the truth, and NEES that of chi-square") {
  std::string options = "--runs " + std::to_string(runs) + " --jobs 2 --seed 1 --quiet";
  for (const char* variant : {"noise x 0.1", "noise x 10"})
    options += std::string(" --set '/study/variants/") + variant + "=null'";
  const auto study = papers::summary_of("study", "aiding/at-rest.json", options);
  const boost::math::chi_squared distribution(dof * runs);
  const double low = boost::math::quantile(distribution, 0.005) / runs,
               high = boost::math::quantile(boost::math::complement(distribution, 0.005)) / runs;
  for (const char* variant : {"gravity at rest", "psi", "20 m/s", "zero rotation"}) {
    const double mean = papers::over_runs(study, variant, nees, "mean");
    CAPTURE(variant, mean);
    CHECK(mean > low);
    CHECK(mean < high);
  }
  for (const char* variant : {"gravity at rest", "psi", "20 m/s"})
    CHECK(std::abs(papers::over_runs(study, variant, sigma, "rms") / possible - 1) < 0.01);
  CHECK(papers::over_runs(study, "zero rotation", sigma, "rms") < 0.3 * possible);
  for (const char* variant : {"with reset", "as measured", "as measured, with reset"}) {
    CAPTURE(variant);
    CHECK(papers::over_runs(study, variant, sigma, "rms") < 0.7 * possible);
    CHECK(papers::over_runs(study, variant, nees, "mean") > high);
  }
}

}  // namespace at_rest_test
