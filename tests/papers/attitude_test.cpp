// SPDX-License-Identifier: Apache-2.0
// Paper 002: the drift tables by `binnacle study`, held to the closed form in extended precision.
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>

#include "../coning_drift.hpp"
#include "catch.hpp"
#include "study_of.hpp"

namespace attitude_test {

namespace {

using binnacle::test::Real;
using nlohmann::ordered_json;

/// The summary of a study of configs/attitude.
ordered_json study(const std::string& config, const std::string& options) {
  return papers::summary_of("study", "attitude/" + config, options + " --jobs 2");
}

/// Of "10 Hz 0.005 s 2 samples double".
struct Variant {
  double frequency = 0, interval = 0;
  int samples = 0;
  std::string precision;

  explicit Variant(const std::string& name) {
    std::istringstream in(name);
    std::string word;
    in >> frequency >> word >> interval >> word >> samples >> word >> precision;
  }
  /// Computed minus true after `duration`, in degrees.
  double drift(double duration) const {
    const Real pi = boost::math::constants::pi<Real>();
    // What is meant by 0.005, not the double next to it.
    const Real h = round(Real(interval) * 1000) / 1000;
    const Real radians =
        binnacle::test::secular_drift(samples, 2 * pi / 180, 2 * pi * Real(frequency) * h, Real(duration) / h);
    return static_cast<double>(radians * 180 / pi);
  }
};

/// Every double cell of the summary whose drift in 60 minutes is above 1e-6 deg, to 1e-4; how many there were.
int check_cells(const ordered_json& summary, double duration, double resolution) {
  int cells = 0;
  for (const auto& [name, entry] : summary.at("variants").items()) {
    const Variant variant(name);
    const auto& figures = entry.at("metrics").at("body/attitude.north/drift");
    REQUIRE(figures.at("unit") == "deg");
    const double drift = -figures.at("mean").get<double>(), closed = variant.drift(duration);
    INFO(name << ": " << drift << " deg in " << duration << " s, in closed form " << closed);
    if (variant.precision == "float") {
      CHECK(std::abs(drift - closed) < 0.02 * std::abs(closed) + 0.01);
    } else if (std::abs(variant.drift(3600)) > 1e-6) {
      CHECK(std::abs(drift - closed) < 1e-4 * std::abs(closed) + resolution);
      ++cells;
    }
  }
  return cells;
}

/// How many cells of float differ from those of double by more than 1e-7 deg: what 24 bits do to an attitude.
int cells_that_float_changes(const ordered_json& summary) {
  int cells = 0;
  const auto drift = [&](const std::string& name) {
    return summary.at("variants").at(name).at("metrics").at("body/attitude.north/drift").at("mean").get<double>();
  };
  for (const auto& [name, entry] : summary.at("variants").items())
    if (const auto at = name.find("float"); at != std::string::npos)
      cells += std::abs(drift(name) - drift(name.substr(0, at) + "double")) > 1e-7 ? 1 : 0;
  return cells;
}

ordered_json cell(const ordered_json& summary, std::size_t table, const std::string& row, const std::string& column) {
  const auto& plan = summary.at("tables").at(table);
  for (std::size_t r = 0; r < plan.at("rows").size(); ++r)
    for (std::size_t c = 0; c < plan.at("columns").size(); ++c)
      if (plan.at("rows")[r] == row && plan.at("columns")[c] == column) return plan.at("cells")[r][c];
  FAIL("no cell " << row << ", " << column);
  return {};
}

}  // namespace

TEST_CASE("paper 002, figures 1 and 2: drift of every cell in 36 s against the closed form, aliased ones marked") {
  const ordered_json summary = study("drift.json", "--set '/sources/coning/duration=36'");
  CHECK(summary.at("variants").size() == 102);
  // A hundredth of the hour, and so of the drift; what doubles add in it is below 1e-12 deg.
  CHECK(check_cells(summary, 36, 1e-12) >= 40);
  CHECK(cells_that_float_changes(summary) >= 45);
  for (std::size_t table = 0; table < 6; ++table) {
    for (const auto& [row, column] : {std::pair("0.04 s", "20 Hz"), {"0.04 s", "25 Hz"}, {"0.02 s", "25 Hz"}})
      CHECK(cell(summary, table, row, column) == "aliased");
    CHECK(cell(summary, table, "0.01 s", "25 Hz").is_number());
  }
}

TEST_CASE("paper 002, cells that are known, over the whole hour") {
  const std::string common = " --set '/study/tables=[]' --set '/study/dimensions/precision={\"double\": {}}'";
  const auto motion = [](const std::string& frequency, const std::string& interval) {
    return "--set '/study/dimensions/motion={\"" + frequency + " Hz " + interval +
           " s\": {\"sources\": {\"coning\": {\"frequency\": " + frequency + ", \"interval\": " + interval + "}}}}'";
  };
  const ordered_json ten = study("drift.json", motion("10", "0.005") + common);
  const ordered_json twenty = study("drift.json", motion("20", "0.02") + common);
  check_cells(ten, 3600, 0);
  check_cells(twenty, 3600, 0);
  const auto drift = [](const ordered_json& summary, const std::string& variant) {
    return -summary.at("variants").at(variant).at("metrics").at("body/attitude.north/drift").at("mean").get<double>();
  };
  CHECK(std::abs(drift(ten, "10 Hz 0.005 s 2 samples double") + 0.1596) < 1e-4);
  CHECK(std::abs(drift(twenty, "20 Hz 0.02 s 4 samples double") + 1.993) < 1e-3);
  // Below W h of about 0.4 the term of the fourth power of the cone makes four samples worse than three: here 0.31.
  CHECK(std::abs(drift(ten, "10 Hz 0.005 s 4 samples double")) >
        std::abs(drift(ten, "10 Hz 0.005 s 3 samples double")));
  CHECK(std::abs(drift(twenty, "20 Hz 0.02 s 4 samples double")) <
        0.1 * std::abs(drift(twenty, "20 Hz 0.02 s 3 samples double")));
}

TEST_CASE("paper 002, where four samples begin to be better than three, in closed form") {
  const Real pi = boost::math::constants::pi<Real>(), cone = 2 * pi / 180;
  const auto ratio = [&](const Real& epsilon, double x) {
    return static_cast<double>(
        abs(binnacle::test::secular_drift(4, epsilon, x, 1) / binnacle::test::secular_drift(3, epsilon, x, 1)));
  };
  double crossing = 0;
  for (double x = 0.2; x < 1 && crossing == 0; x += 0.001)
    if (ratio(cone, x) < 1) crossing = x;
  INFO("at W h = " << crossing);
  CHECK(std::abs(crossing - 0.4) < 0.05);
  // It is the size of the cone that does it: on a tiny one four samples are better everywhere.
  CHECK(ratio(cone, 0.1) > 1);
  CHECK(ratio(cone / 1000000, 0.1) < 1e-3);
}

TEST_CASE("paper 002, table 1: truncation matters little only where order 2 means two terms") {
  const ordered_json summary =
      study("truncation.json",
            "--set '/sources/coning/duration=36' --set '/study/dimensions/precision={\"double\": {}}'"
            " --set '/study/tables=[]'");
  const auto drift = [&](const std::string& interval, const std::string& truncation) {
    const auto& entry = summary.at("variants").at("double " + interval + " " + truncation);
    return -entry.at("metrics").at("body/attitude.north/drift").at("mean").get<double>();
  };
  for (const std::string interval : {"0.04 s", "0.01 s"}) {
    const double exact = drift(interval, "exact");
    INFO(interval << ": " << exact << ", power 2 " << drift(interval, "power 2") << ", 2 terms "
                  << drift(interval, "2 terms"));
    CHECK(std::abs(drift(interval, "power 2") - exact) > 100 * std::abs(exact));
    CHECK(std::abs(drift(interval, "2 terms") - exact) < 0.1 * std::abs(exact));
    for (const char* fine : {"power 5", "4 terms", "5 terms"})
      CHECK(std::abs(drift(interval, fine) - exact) < 1e-4 * std::abs(exact) + 1e-12);
  }
}

TEST_CASE("coning and sculling in a mechanization: what the choice buys") {
  const ordered_json summary = study("trajectory.json", "");
  const auto figure = [&](const std::string& variant, const std::string& metric) {
    return std::abs(summary.at("variants").at(variant).at("metrics").at(metric).at("mean").get<double>());
  };
  const std::string drift = "ins/attitude.north/drift", sculling = "ins/velocity.north/max";
  // At the same updates every sample more buys a factor of ten and more, until other things weigh.
  CHECK(figure("1 sample and the previous, 12 ms", drift) < 0.2 * figure("1 sample alone, 12 ms", drift));
  CHECK(figure("2 samples, 12 ms", drift) < 0.1 * figure("1 sample and the previous, 12 ms", drift));
  CHECK(figure("3 samples, 12 ms", drift) < 0.01 * figure("2 samples, 12 ms", drift));
  CHECK(figure("4 samples, 12 ms", drift) < 0.3 * figure("3 samples, 12 ms", drift));
  CHECK(figure("1 sample and the previous, 12 ms", sculling) < 0.2 * figure("1 sample alone, 12 ms", sculling));
  CHECK(figure("2 samples, 12 ms", sculling) < 0.1 * figure("1 sample and the previous, 12 ms", sculling));
  CHECK(figure("3 samples, 12 ms", sculling) < 0.5 * figure("2 samples, 12 ms", sculling));
  // On a coning motion the coning form is the better one.
  CHECK(figure("3 samples, 12 ms", drift) < 0.1 * figure("3 samples, polynomial, 12 ms", drift));
  // At the same samples two of them are no better than one and the one before.
  CHECK(std::abs(figure("2 samples, 1 kHz", drift) / figure("1 sample and the previous, 1 kHz", drift) - 1) < 0.1);
}

TEST_CASE("paper 002, the whole of the drift tables over the hour", "[.full]") {
  CHECK(check_cells(study("drift.json", ""), 3600, 0) >= 40);
}

}  // namespace attitude_test
