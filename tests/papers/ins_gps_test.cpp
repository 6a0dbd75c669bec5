// SPDX-License-Identifier: Apache-2.0
// Paper 003: straight flight, outage and turns by `binnacle study`, with fewer runs than the configs ask for; and what a
// tightly coupled filter does about a satellite gone wrong and a receiver's clock that jumps.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "catch.hpp"
#include "study_of.hpp"

namespace ins_gps_test {

using papers::over_runs;
using papers::summary_of;

namespace {

const std::vector<std::string> cells = {"lc low", "tc low", "lc high", "tc high"};

nlohmann::ordered_json measurement(const nlohmann::ordered_json& summary, const char* name) {
  return summary.at("filters").at("ins").at("measurements").at(name);
}

}  // namespace

TEST_CASE("paper 003, straight flight: the position is GPS's in every cell, the attitude the sensors'") {
  const auto summary = summary_of("study", "ins_gps/straight.json", "--runs 16 --jobs 2");
  std::vector<double> cep;
  // Over 16 runs the mean of a CEP scatters by 0.9 m: the config's 50 hold 7 m (configs/ins_gps/README.md), these 8.
  for (const auto& cell : cells) cep.push_back(over_runs(summary, cell, "ins/position.horizontal/p50", "mean"));
  for (const double c : cep) CHECK(c <= 8);
  const auto [least, most] = std::minmax_element(cep.begin(), cep.end());
  CHECK(*most / *least <= 1.15);
  for (const std::string coupling : {"lc", "tc"})
    CHECK(over_runs(summary, coupling + " low", "ins/attitude.tilt/rms", "mean") >=
          20 * over_runs(summary, coupling + " high", "ins/attitude.tilt/rms", "mean"));
}

TEST_CASE(
    "paper 003, figure 1: an outage is the sensors' affair, and satellites too few for a position still help tightly") {
  const auto summary = summary_of("study", "ins_gps/outage.json", "--runs 12 --jobs 2");
  const auto end = [&](const std::string& variant) {
    return over_runs(summary, variant, "ins/position.horizontal/at 399 s", "rms");
  };
  for (const std::string coupling : {"lc", "tc"}) {
    CHECK(end(coupling + " low") >= 4 * end(coupling + " high"));
    CHECK(end(coupling + " low") >= 40);
    CHECK(end(coupling + " low") <= 120);
  }
  CHECK(end("tc low 3 sats") <= 0.35 * end("lc low 3 sats"));
  CHECK(end("tc low 2 sats") <= 0.8 * end("lc low 2 sats"));
}

TEST_CASE("paper 003, table 2: in turns the loosely coupled filter hangs on what the GPS filter expects") {
  const auto summary = summary_of("study", "ins_gps/table2.json", "--runs 8 --jobs 2");
  const auto ratio = [&](const std::string& S_a) {
    return over_runs(summary, "lc sa=" + S_a, "ins/position.horizontal/p50", "mean") /
           over_runs(summary, "tc sa=" + S_a, "ins/position.horizontal/p50", "mean");
  };
  CHECK(ratio("0.12") >= 1.03);
  CHECK(ratio("0.12") <= 1.3);
  CHECK(ratio("0.03") > ratio("0.12"));
  for (const char* S_a : {"3", "10", "30"}) CHECK(std::abs(ratio(S_a) - 1) < 0.03);
}

TEST_CASE("a satellite with 1 km error is left out, reported and survived, and only that one") {
  const std::string gated =
      R"(--variant "tc low" --set '/filters/ins/measurements/ranges/gate={"probability": 0.99999, "by": "key"}')";
  const auto clean = summary_of("run", "ins_gps/straight.json", gated);
  CHECK(measurement(clean, "ranges").at("left_out").at("rows") == 0);
  const auto faulty = summary_of(
      "run", "ins_gps/straight.json",
      gated +
          R"( --set '/transforms/gnss/faults=[{"satellite": "G05", "from": "200 s", "to": "300 s", "pseudorange": "1 km"}]')");
  const auto ranges = measurement(faulty, "ranges");
  CHECK(ranges.at("gated") == 0);
  CHECK(ranges.at("accepted") == measurement(clean, "ranges").at("accepted"));
  // A pseudorange and a range rate at each of 101 epochs.
  CHECK(ranges.at("left_out").at("by_key") == nlohmann::ordered_json({{"105", 202}}));
  const auto p50 = [](const nlohmann::ordered_json& summary) {
    return summary.at("filters").at("ins").at("reference").at("position.horizontal").at("max").get<double>();
  };
  CHECK(p50(faulty) < p50(clean) + 2);
}

TEST_CASE("a receiver clock that jumps by 1 ms is met by recovery") {
  const auto summary = summary_of(
      "run", "ins_gps/straight.json",
      R"(--variant "tc low" --set '/filters/ins/measurements/ranges/gate={"probability": 0.99999, "by": "key"}' )"
      R"(--set '/filters/ins/measurements/ranges/recover={"after": 3, "inflate": {"clock.bias": "1000 km"}}' )"
      R"(--set '/transforms/gnss/clock_jumps=[{"at": "250 s", "jump": "1 ms"}]')");
  const auto ranges = measurement(summary, "ranges");
  CHECK(ranges.at("gated") == 3);
  CHECK(ranges.at("recoveries") == 1);
  CHECK(ranges.at("last_reason") == "no majority of its rows agrees with the rest");
  CHECK(summary.at("filters").at("ins").at("reference").at("position.horizontal").at("final").get<double>() < 30);
}

}  // namespace ins_gps_test
