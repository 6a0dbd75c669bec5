// SPDX-License-Identifier: Apache-2.0
// The troposphere's delay: Niell's mapping functions against niell.py, which was written from the paper by itself.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <vector>

#include "catch.hpp"
#include "gnss/atmosphere.hpp"

namespace troposphere_test {

using namespace binnacle::gnss;

namespace {

constexpr double degree = M_PI / 180;

struct OracleRow {
  double lat, height, day, elevation, hydrostatic, wet, slant, zenith;
};

std::vector<OracleRow> oracle() {
  FILE* const pipe = ::popen(BINNACLE_TEST_PYTHON " " BINNACLE_TEST_PROJECT "/tests/gnss/niell.py", "r");
  REQUIRE(pipe != nullptr);
  std::vector<OracleRow> rows;
  OracleRow r{};
  while (std::fscanf(pipe, "%lf %lf %lf %lf %lf %lf %lf %lf", &r.lat, &r.height, &r.day, &r.elevation, &r.hydrostatic,
                     &r.wet, &r.slant, &r.zenith) == 8)
    rows.push_back(r);
  REQUIRE(::pclose(pipe) == 0);
  return rows;
}

}  // namespace

TEST_CASE("Niell's mapping functions equal an implementation of their own") {
  const auto rows = oracle();
  REQUIRE(rows.size() == 10 * 4 * 5 * 5);
  double factor = 0, delay = 0;
  for (const OracleRow& r : rows) {
    INFO(r.lat << " deg, " << r.height << " m, day " << r.day << ", at " << r.elevation << " deg");
    const double season = r.day < 0 ? 0 : season_of(r.day), el = r.elevation * degree;
    const NiellFactors f = niell_factors(r.lat * degree, r.height, el, season);
    const double slant = troposphere_delay(Mapping::niell, r.lat * degree, r.height, el, season).delay;
    factor = std::max({factor, std::abs(f.hydrostatic - r.hydrostatic), std::abs(f.wet - r.wet)});
    delay = std::max(delay, std::abs(slant - r.slant));
    CHECK(std::abs(f.hydrostatic - r.hydrostatic) < 1e-10);
    CHECK(std::abs(f.wet - r.wet) < 1e-10);
    CHECK(std::abs(slant - r.slant) < 1e-9);
    if (r.lat != 45 || r.height != 0 || r.day >= 0) continue;
    const double flat = troposphere_delay(Mapping::cosecant, r.lat * degree, 0, el, 0).delay;
    const double winter = troposphere_delay(Mapping::niell, r.lat * degree, 0, el, season_of(28)).delay;
    std::printf("45 deg N at %2.0f deg: %.4f m, python %.4f m; 1/sin %+.4f m, midwinter %+.4f m\n", r.elevation, slant,
                r.slant, flat - slant, winter - slant);
  }
  std::printf("Niell: factors %.0e, delays %.0e m at most from python's, %zu rows\n", factor, delay, rows.size());
}

TEST_CASE("the season of the mapping is the hemisphere's own") {
  const auto at = [](double lat, double day) {
    return niell_factors(lat * degree, 0, 5 * degree, season_of(day)).hydrostatic;
  };
  CHECK(season_of(28) == 1);
  CHECK(at(45, 28) > at(45, 28 + 365.25 / 2));
  CHECK(at(-45, 28) < at(-45, 28 + 365.25 / 2));
  CHECK(std::abs(at(-45, 28) - at(45, 28 + 365.25 / 2)) < 1e-12);
  CHECK(at(10, 28) == at(10, 210));  // none in the tropics
}

}  // namespace troposphere_test
