// SPDX-License-Identifier: Apache-2.0
// What goes into a page: decimation, columns, escapes, units, consistency, the track.
#include "../catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "columns.hpp"
#include "consistency.hpp"
#include "decimation.hpp"
#include "display.hpp"
#include "escape.hpp"
#include "fixture.hpp"
#include "payload.hpp"
#include "report/page.hpp"
#include "track.hpp"

namespace parts_test {

using namespace binnacle;
using namespace binnacle::report;

namespace {

std::vector<double> noise(std::size_t n) {
  std::vector<double> values;
  double x = 0.3;
  for (std::size_t i = 0; i < n; ++i) values.push_back(x = 3.9 * x * (1 - x));
  return values;
}

bool has(const std::vector<std::size_t>& indices, std::size_t index) {
  return std::binary_search(indices.begin(), indices.end(), index);
}

}  // namespace

TEST_CASE("Decimation: what there is few of is kept whole") {
  const auto values = noise(100);
  const auto kept = extremes({values}, 100);
  REQUIRE(kept.size() == 100);
  REQUIRE(kept.back() == 99);
}

TEST_CASE("Decimation: no more than asked for, in order, ends and every peak there") {
  auto values = noise(1'000'000);
  auto sigma = noise(1'000'000);
  std::reverse(sigma.begin(), sigma.end());
  values[123'457] = 50;
  values[777'777] = -50;
  sigma[400'001] = 9;
  const auto kept = extremes({values, sigma}, 20'000);
  REQUIRE(kept.size() <= 20'000);
  REQUIRE(kept.size() > 15'000);
  REQUIRE(std::is_sorted(kept.begin(), kept.end()));
  REQUIRE(std::adjacent_find(kept.begin(), kept.end()) == kept.end());
  for (const std::size_t index : {0U, 123'457U, 400'001U, 777'777U, 999'999U}) REQUIRE(has(kept, index));
}

TEST_CASE("Decimation: NaN is passed over, a stretch of nothing but NaN is left out") {
  auto values = noise(10'000);
  for (std::size_t i = 2000; i < 6000; ++i) values[i] = std::nan("");
  const auto kept = extremes({values}, 500);
  for (const auto i : kept) REQUIRE(std::isfinite(values[i]));
}

TEST_CASE("Decimation: a kind that is seldom is not lost") {
  std::vector<std::uint8_t> kinds(100'000, 0);
  kinds[54'321] = 1;
  const auto values = noise(kinds.size());
  const auto kept = extremes_of_kinds({values}, kinds, 1000);
  REQUIRE(kept.size() <= 1000);
  REQUIRE(has(kept, 54'321));
  REQUIRE(has(extremes_of_kinds({}, kinds, 1000), 54'321));
}

TEST_CASE("Decimation: a path's points lie apart, its ends are kept") {
  std::vector<double> x, y(1001, 0.0);
  for (std::size_t i = 0; i < y.size(); ++i) x.push_back(0.1 * static_cast<double>(i));
  const auto kept = spaced(x, y, 1.05);
  REQUIRE(kept.front() == 0);
  REQUIRE(kept.back() == 1000);
  REQUIRE(kept[1] == 11);
  REQUIRE(spaced({}, {}, 1).empty());
}

TEST_CASE("Columns: base64 as RFC 4648 has it") {
  REQUIRE(base64("") == "");
  REQUIRE(base64("f") == "Zg==");
  REQUIRE(base64("fo") == "Zm8=");
  REQUIRE(base64("foobar") == "Zm9vYmFy");
  REQUIRE(base64(std::string("\0\xff\xfe", 3)) == "AP/+");
}

TEST_CASE("Columns: equal ones once, only what varies little about a large number has an offset") {
  Columns columns;
  const std::vector<double> times{0, 1, 2}, latitude{43.1234567, 43.1234568, 43.1234569}, start{1e6, 1, 1e-3};
  REQUIRE(columns.exact(times) == columns.exact(times));
  const int a = columns.plotted(latitude), b = columns.plotted(start);
  const Json list = std::move(columns).json();
  REQUIRE(list.size() == 3);
  REQUIRE(std::abs(list[static_cast<std::size_t>(a)].at("o").get<double>() - 43.1234568) < 1e-9);
  REQUIRE(!list[static_cast<std::size_t>(b)].contains("o"));
}

TEST_CASE("Escapes: nothing ends a script or opens an element") {
  REQUIRE(html("<a b='c'>\"&") == "&lt;a b=&#39;c&#39;&gt;&quot;&amp;");
  REQUIRE(html("\xff") == "\xef\xbf\xbd");
  const Json evil{{"</script><!--", "\xff<script>"}};
  const std::string text = script_json(evil);
  REQUIRE(text.find('<') == std::string::npos);
  REQUIRE(Json::parse(text).begin().key() == "</script><!--");
}

TEST_CASE("Units: as declared, else angles in degrees and slow rates per hour") {
  const std::vector<double> slow{1e-6}, fast{0.3};
  REQUIRE(display_of("rad", "mil", {}).unit == "mil");
  REQUIRE(std::abs(display_of("rad", "mil", {}).scale - 2 * M_PI / 6400) < 1e-15);
  REQUIRE(display_of("rad", "", {}).unit == "deg");
  REQUIRE(display_of("rad/s", "rad/s", slow).unit == "deg/h");
  REQUIRE(display_of("rad/s", "", fast).unit == "deg/s");
  REQUIRE(display_of("m", "", {}).unit == "m");
  REQUIRE(display_of("1", "1", {}).unit.empty());
  REQUIRE(display_of("m", "deg", {}).scale == 1);
}

TEST_CASE("Consistency: shares within sigma, and chi-squared bounds as tables have them") {
  const std::vector<double> errors{0.5, -1.5, 2.5, 3.5, 1}, sigma{1, 1, 1, 1, 0};
  const Within within = within_sigma(errors, sigma);
  REQUIRE(within.of == 4);
  REQUIRE(within.one == 1);
  REQUIRE(within.two == 2);
  REQUIRE(within.three == 3);
  const auto [low, high] = chi_squared_95(3);
  REQUIRE(std::abs(low - 0.215795) < 1e-5);
  REQUIRE(std::abs(high - 9.348404) < 1e-5);
  REQUIRE(chi_squared_95(0).second == 0);
  const auto [least, most] = mean_chi_squared_99(2, 10);  // chi-squared of 20: 7.43384, 39.99685
  REQUIRE(std::abs(least - 0.743384) < 1e-5);
  REQUIRE(std::abs(most - 3.999685) < 1e-5);
}

TEST_CASE("Consistency: means of so many values one after the other") {
  std::vector<double> t, values;
  for (int i = 0; i < 1000; ++i) {
    t.push_back(i);
    values.push_back(i < 500 ? 1 : 3);
  }
  const MovingMean moving = moving_mean(t, values, 2);
  REQUIRE(moving.mean.front() == 1);
  REQUIRE(moving.mean.back() == 3);
  REQUIRE(moving.low < 2);
  REQUIRE(moving.high > 2);
  REQUIRE(moving_mean({}, {}, 2).t.empty());
}

TEST_CASE("Track: metres east and north of the start, the reference is the estimate plus its error") {
  const auto results = test::run_results("ins", 1000);
  const auto track = track_of(results.run->filters.front());
  REQUIRE(track);
  REQUIRE(track->estimate.east.front() == 0);
  // A quarter of the way round: 3e-5 rad north, at 45.8 degrees of latitude 6 368 km per rad.
  REQUIRE(std::abs(track->estimate.north[250] - 3e-5 * 6.3682e6) < 0.01);
  // Longitude: 6 389 km of transverse radius times the cosine of 0.8 rad.
  REQUIRE(std::abs(track->estimate.east[250] + 4e-5 * 6.3891e6 * std::cos(0.8)) < 0.01);
  REQUIRE(track->reference.t.size() == 1000);
  const auto& north = results.run->filters.front().errors.front().values;
  REQUIRE(std::abs(track->reference.north[33] - track->estimate.north[33] - north[33]) < 1e-9);
  REQUIRE(std::abs(track->sigma.front() - std::hypot(1e-7 * 6.3682e6, 1.5e-7 * 6.3891e6 * std::cos(0.8))) < 1e-4);
}

TEST_CASE("Payload: windows in the filter's time, a seed beyond a script's numbers as text") {
  const Json json = payload(test::run_results("ins", 1000), {});
  const Json& run = json.at("run");
  REQUIRE(run.at("provenance").at("seed") == Json("18446744073709551615"));
  const Json& window = run.at("filters")[0].at("windows")[0];
  REQUIRE(window.at("from") == Json(30.0));
  REQUIRE(window.at("to") == Json(50.0));
  REQUIRE(run.at("summary").at("filters").at("ins").at("steps") == Json(1000));
}

TEST_CASE("Payload: NIS bounds, gated samples and the reasons of what was not used") {
  const Json json = payload(test::run_results("ins", 10'000), {});
  const Json& fix = json.at("run").at("filters")[0].at("measurements")[0];
  REQUIRE(fix.at("nis").at("dof") == Json(2.0));
  REQUIRE(std::abs(fix.at("nis").at("high").get<double>() - 7.377759) < 1e-5);
  REQUIRE(fix.at("outcomes").at("counts")[1].get<int>() > 0);
  REQUIRE(fix.at("reasons")[0].at("count").get<int>() >= fix.at("reasons")[1].at("count").get<int>());
  REQUIRE(fix.at("residuals").size() == 2);
  REQUIRE(fix.at("noise")[0].at("constant") == Json(0.5));
  REQUIRE(fix.at("noise")[1].contains("v"));
}

TEST_CASE("Payload: a million samples make a page of a few megabytes") {
  const auto results = test::run_results("ins", 1'000'000);
  const std::string text = page(results);
  REQUIRE(text.size() < 12'000'000);
  REQUIRE(text.find("{{title}}") == std::string::npos);
  const Json track = payload(results, {}).at("run").at("filters")[0].at("track");
  REQUIRE(track.at("reference").at("points").get<int>() <= 4000);
}

TEST_CASE("Page: fetches nothing, and holds the licence of what it brings along") {
  const std::string text = page(test::run_results("ins", 100));
  for (const char* never : {"src=\"http", "href=\"http", "@import", "url("})
    REQUIRE(text.find(never) == std::string::npos);
  REQUIRE(text.find("Permission is hereby granted") != std::string::npos);
  REQUIRE(text.find("default-src 'none'") != std::string::npos);
}

TEST_CASE("Page: its limits are those that the guide states") {
  const Limits limits;
  REQUIRE(limits.numbers == 1'500'000);
  REQUIRE(limits.most_points == 20'000);
  REQUIRE(limits.least_points == 1'000);
}

}  // namespace parts_test
