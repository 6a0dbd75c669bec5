// SPDX-License-Identifier: Apache-2.0
// configs/clone: with a copy of the state, filters of displacements know how wrong they are; without one they do not.
#include <cmath>
#include <string>

#include <boost/math/distributions/chi_squared.hpp>

#include "../papers/study_of.hpp"
#include "catch.hpp"

namespace clone_test {

namespace {

constexpr int runs = 40;
const char* const instants[] = {"60 s", "95 s", "130 s"};
constexpr double confidence = 0.99;

double nees(const nlohmann::ordered_json& summary, const std::string& variant, const std::string& of,
            const char* instant) {
  return papers::over_runs(summary, variant, "ins/" + of + "/nees at " + instant, "mean");
}

/// Where the mean over the runs of `dof` degrees of freedom lies, for `statements` at once.
std::pair<double, double> band(double dof, int statements) {
  const boost::math::chi_squared distribution(dof * runs);
  const double tail = (1 - confidence) / statements / 2;
  return {boost::math::quantile(distribution, tail) / runs,
          boost::math::quantile(boost::math::complement(distribution, tail)) / runs};
}

}  // namespace

TEST_CASE("with copies of the state, the NEES of filters of displacements is that of chi-square") {
  const auto summary = papers::summary_of("study", "clone/outage.json",
                                          "--runs " + std::to_string(runs) +
                                              " --jobs 1 --seed 11 --set '/study/variants/inertial=null' --quiet");
  constexpr int statements = 4 * 4;
  for (const char* variant : {"clone", "carrier", "lever arm", "ecef"}) {
    for (const char* instant : instants) {
      CAPTURE(variant, instant);
      const auto [low, high] = band(15, statements);
      const double mean = nees(summary, variant, "state", instant);
      CHECK(mean > low);
      CHECK(mean < high);
    }
    const auto [low, high] = band(3, statements);
    CHECK(nees(summary, variant, "position", "130 s") > low);
    CHECK(nees(summary, variant, "position", "130 s") < high);
  }
  // What it is tempting to do: the begin of a way is known, a way by its time is the velocity. No band is near.
  for (const char* variant : {"known", "mean velocity"})
    for (const char* instant : instants) {
      CAPTURE(variant, instant);
      CHECK(nees(summary, variant, "state", instant) > 2 * band(15, statements).second);
    }
}

TEST_CASE("a copy of what does not move makes P singular for good, and changes nothing") {
  // From the first copy on.
  const auto of = [](const std::string& options) {
    return papers::summary_of("run", "clone/outage.json", options + " --quiet --set /evaluate/after=1")
        .at("filters")
        .at("ins");
  };
  const auto plain = of(""), singular = of("--variant singular");
  const auto &regular_state = plain.at("consistency").at("state"), &state = singular.at("consistency").at("state");
  CHECK(regular_state.at("dof") == 15);
  CHECK(state.at("blocks").size() == regular_state.at("blocks").size() + 1);
  CHECK(state.at("dof") == 15);  // of 18 components
  CHECK(std::abs(state.at("nees_mean").get<double>() / regular_state.at("nees_mean").get<double>() - 1) < 1e-6);
  const char* const error = "position.horizontal";
  CHECK(std::abs(singular.at("reference").at(error).at("rms").get<double>() /
                     plain.at("reference").at(error).at("rms").get<double>() -
                 1) < 1e-9);
}

}  // namespace clone_test
