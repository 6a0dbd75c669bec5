// SPDX-License-Identifier: Apache-2.0
// configs/aiding: an INS without GNSS, with magnetometer, barometer, Doppler log and ranges, is as wrong as the covariance
// analysis says, and knows it.
#include <cmath>
#include <cstdio>
#include <iterator>
#include <string>
#include <utility>

#include <boost/math/distributions/chi_squared.hpp>

#include "../papers/study_of.hpp"
#include "catch.hpp"

namespace aiding_test {

namespace {

constexpr int runs = 100, dof = 26;
const char* const instants[] = {"120 s", "240 s", "360 s", "480 s", "600 s"};

double square(double value) { return value * value; }

}  // namespace

TEST_CASE("ten minutes without GNSS: errors are as the covariance analysis says, NEES that of chi-square") {
  std::string options = "--runs " + std::to_string(runs) + " --jobs 2 --seed 1 --quiet";
  for (const char* sensor : {"magnetometer", "barometer", "DVL", "UWB", "UWB and barometer"})
    options += std::string(" --set '/study/variants/without ") + sensor + "=null'";
  options += " --set '/study/variants/UWB by differences=null'";
  const auto drawn = papers::summary_of("study", "aiding/ins.json", options + " --set /study/table=null");
  const auto computed = papers::summary_of("covariance", "aiding/covariance.json", "--quiet");
  const auto sums = [&](const std::string& error) {
    std::pair<double, double> sum{0, 0};
    for (const std::string instant : instants) {
      sum.first += square(papers::over_runs(drawn, "all", "ins/" + error + "/at " + instant, "rms"));
      sum.second += square(papers::over_runs(computed, "base", "ins/" + error + "/sigma at " + instant, "rms"));
    }
    return sum;
  };
  for (const auto& [one, other] :
       {std::pair{"position.horizontal", "position.down"}, {"attitude.tilt", "attitude.down"}}) {
    const auto a = sums(one), b = sums(other);
    for (const double ratio : {a.first / a.second, b.first / b.second, (a.first + b.first) / (a.second + b.second)}) {
      CAPTURE(one, other, std::sqrt(ratio));
      std::printf("%s, %s: RMS error over sigma %.3f\n", one, other, std::sqrt(ratio));
      CHECK(std::abs(std::sqrt(ratio) - 1) < 0.1);
    }
  }
  // 99 % for all of the instants together.
  const boost::math::chi_squared distribution(dof * runs);
  const double tail = 0.01 / 2 / std::size(instants);
  for (const std::string instant : instants) {
    const double mean = papers::over_runs(drawn, "all", "ins/state/nees at " + instant, "mean");
    CAPTURE(instant, mean);
    CHECK(mean > boost::math::quantile(distribution, tail) / runs);
    CHECK(mean < boost::math::quantile(boost::math::complement(distribution, tail)) / runs);
  }
}

}  // namespace aiding_test
