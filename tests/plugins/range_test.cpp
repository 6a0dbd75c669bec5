// SPDX-License-Identifier: Apache-2.0
// Plugin aiding, range: distances in all kinds of coordinates, the sign of each derivative, rows that are left out.
#include "../../plugins/aiding/range.hpp"

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "refusal.hpp"
#include "strapdown/earth.hpp"
#include "support/navigation_kinds.hpp"

namespace range_test {

using namespace binnacle;
using namespace binnacle::aiding;
using namespace binnacle::test;
using Eigen::Vector3d;

namespace {

using Row = std::map<std::string, double>;
const std::vector<std::string> names = {"range",        "anchor",        "range_sd",   "range_variance", "anchor_lat",
                                        "anchor_lon",   "anchor_height", "anchor_x",   "anchor_y",       "anchor_z",
                                        "anchor_north", "anchor_east",   "anchor_down"};

/// Rows of a channel that carries these fields.
struct Rows {
  explicit Rows(const std::vector<Row>& rows) {
    for (const Row& row : rows)
      for (const std::string& name : names) numbers.push_back(row.contains(name) ? row.at(name) : NAN);
  }
  operator SampleView() const { return testing::rows_of(numbers, static_cast<int>(names.size()), 0); }
  std::vector<double> numbers;
};

/// All fields but these.
std::vector<std::string> without(const std::vector<std::string>& carried) {
  std::vector<std::string> rest;
  for (const std::string& name : names)
    if (!contains(carried, name)) rest.push_back(name);
  return rest;
}

constexpr double degree = M_PI / 180;
const nlohmann::json three = {{"105", {{"north", 0}, {"east", 0}, {"down", 0}}},
                              {"107", {{"north", 30}, {"east", 0}, {"down", -4}, {"bias", 0.5}}},
                              {"109", {{"north", 0}, {"east", 40}, {"down", 5}, {"sigma", 0.3}}}};

}  // namespace

TEST_CASE("range: in local axes, each sign", "[aiding]") {
  const AdditiveKind position(3, "m"), bias(3, "m");
  const auto model = bind<Range>({{{"sigma", 0.1}, {"anchors", three}, {"relative", 0.01}},
                                  {{"position", &position}, {"bias", &bias}},
                                  without({"range", "anchor"})});
  REQUIRE(model->declaration().max_rows == 3);
  const PortStates ports{{&position, {3, 4, 12}, 1.0, 1e-9}, {&bias, {0.1, 0.2, 0.3}, 0.1, 1e-9}};
  // In another order than listed; the second is 13 m away.
  const Rows sample({{{"range", 50}, {"anchor", 109}}, {{"range", 13.25}, {"anchor", 105}}});
  Complaints out;
  const Measured m = linearize(*model, sample, ports, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  REQUIRE(m.result);
  REQUIRE(m.residual.size() == 2);
  CHECK(std::abs(m.residual[1] - (13.25 - 13.1)) < 1e-12);
  CHECK(std::abs(m.residual[0] - (50 - std::hypot(3, 36, 7) - 0.3)) < 1e-12);
  CHECK(m.keys == std::vector<std::int64_t>{109, 105});
  // Further north of the anchor the range grows.
  CHECK(m.H[0].row(1).isApprox(Eigen::RowVector3d(3, 4, 12) / 13));
  CHECK(m.H[0](0, 1) < 0);
  CHECK(m.H[1].row(0) == Eigen::RowVector3d(0, 0, 1));
  CHECK(m.H[1].row(1) == Eigen::RowVector3d(1, 0, 0));
  CHECK(std::abs(m.R(0, 0) - (0.09 + 0.25)) < 1e-15);
  CHECK(std::abs(m.R(1, 1) - (0.01 + 0.1325 * 0.1325)) < 1e-15);
  CHECK(m.R(0, 1) == 0);
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, Range::spec(), sample, ports, {}, {1e-6}, 1e-9));
}

TEST_CASE("range: what the config knows of a bias is taken off, and one block may serve all", "[aiding]") {
  const AdditiveKind position(2, "m"), bias(1, "m");
  const auto model = bind<Range>(
      {{{"sigma", 0.1}, {"anchors", three}}, {{"position", &position}, {"bias", &bias}}, without({"range", "anchor"})});
  // In a plane, at down 0: the anchor stands 4 m above it.
  const PortStates ports{{&position, {33, 0}, 0.1, 1e-9}, {&bias, {0.25}, 0.1, 1e-9}};
  const Rows sample({{{"range", 6}, {"anchor", 107}}});
  Complaints out;
  const Measured m = linearize(*model, sample, ports, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  CHECK(std::abs(m.residual[0] - (6 - 5 - 0.5 - 0.25)) < 1e-12);
  CHECK(m.H[0].isApprox(Eigen::RowVector2d(0.6, 0)));
  CHECK(m.H[1](0, 0) == 1);
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, Range::spec(), sample, ports, {}, {1e-6}, 1e-9));
}

TEST_CASE("range: geodetic and ECEF places, anchors in either coordinates, by the config or by the row", "[aiding]") {
  const PositionKind geodetic;
  const AdditiveKind ecef("position.ecef", 3, "m");
  const Vector3d lla(52.5 * degree, 13.4 * degree, 80);
  for (const Vector3d& way : {Vector3d(300, 0, 0), Vector3d(0, -200, 0), Vector3d(10, 20, -50), Vector3d(0, 0, 900)}) {
    CAPTURE(way.transpose());
    const Vector3d of_anchor = strapdown::ecef_from_lla(lla) + strapdown::C_en(lla[0], lla[1]) * way;
    const Vector3d lla_of_anchor = strapdown::lla_from_ecef(of_anchor), here = strapdown::ecef_from_lla(lla);
    const nlohmann::json by_lla{{"lat", lla_of_anchor[0]}, {"lon", lla_of_anchor[1]}, {"height", lla_of_anchor[2]}};
    const nlohmann::json by_ecef{{"x", of_anchor[0]}, {"y", of_anchor[1]}, {"z", of_anchor[2]}};
    const Row row_by_ecef{{"range", way.norm() + 1},
                          {"anchor_x", of_anchor[0]},
                          {"anchor_y", of_anchor[1]},
                          {"anchor_z", of_anchor[2]}};
    const Row row_by_lla{{"range", way.norm() + 1},
                         {"anchor_lat", lla_of_anchor[0]},
                         {"anchor_lon", lla_of_anchor[1]},
                         {"anchor_height", lla_of_anchor[2]}};
    const Row row{{"range", way.norm() + 1}, {"anchor", 7}};
    const std::vector<std::pair<Setup, Row>> cases = {
        {{{{"anchors", {{"7", by_lla}}}}, {}, without({"range", "anchor"})}, row},
        {{{{"anchors", {{"7", by_ecef}}}}, {}, without({"range"})}, row},  // the only one there is
        {{{}, {}, without({"range", "anchor_x", "anchor_y", "anchor_z"})}, row_by_ecef},
        {{{}, {}, without({"range", "anchor_lat", "anchor_lon", "anchor_height"})}, row_by_lla}};
    for (auto [setup, fields] : cases)
      for (const bool is_geodetic : {true, false}) {
        setup.parameters["sigma"] = 0.1;
        const StateBlock& block = is_geodetic ? static_cast<const StateBlock&>(geodetic) : ecef;
        setup.ports = {{"position", &block}};
        const Vector3d place = is_geodetic ? lla : here;
        const PortStates ports{{&block, {place[0], place[1], place[2]}, 1.0, 1e-8}, {}};
        const auto model = bind<Range>(setup);
        Complaints out;
        const Measured m = linearize(*model, Rows({fields}), ports, {}, out);
        REQUIRE_NO_COMPLAINTS(out);
        REQUIRE(m.result);
        CHECK(std::abs(m.residual[0] - 1) < 1e-8);
        // Towards the anchor it shrinks.
        const Vector3d towards = is_geodetic ? way : Vector3d(strapdown::C_en(lla[0], lla[1]) * way);
        CHECK(m.H[0].isApprox(-towards.transpose() / way.norm(), 1e-7));
        REQUIRE_NO_COMPLAINTS(check_measurement(*model, Range::spec(), Rows({fields}), ports, {}, {1e-6}, 1e-8));
      }
  }
}

TEST_CASE("range: local anchors for a place on the earth, and the other way round, by the origin", "[aiding]") {
  const PositionKind geodetic;
  const AdditiveKind local(3, "m");
  const Vector3d lla(52.5 * degree, 13.4 * degree, 80), at(2000, -3000, -40), anchor(2030, -3040, -40);
  const Vector3d r_e = strapdown::ecef_from_lla(lla);
  const Eigen::Matrix3d C = strapdown::C_en(lla[0], lla[1]);
  const nlohmann::json origin{{"lat", lla[0]}, {"lon", lla[1]}, {"height", lla[2]}};
  const Vector3d lla_at = strapdown::lla_from_ecef(r_e + C * at), anchor_e = r_e + C * anchor;
  const nlohmann::json by_local{{"north", anchor[0]}, {"east", anchor[1]}, {"down", anchor[2]}},
      by_ecef{{"x", anchor_e[0]}, {"y", anchor_e[1]}, {"z", anchor_e[2]}};
  const Rows sample({{{"range", 51}, {"anchor", 1}}});
  for (const bool is_geodetic : {true, false}) {
    const StateBlock& block = is_geodetic ? static_cast<const StateBlock&>(geodetic) : local;
    const Vector3d x = is_geodetic ? lla_at : at;
    const PortStates ports{{&block, {x[0], x[1], x[2]}, 1.0, 1e-8}, {}};
    const auto model =
        bind<Range>({{{"sigma", 0.1}, {"origin", origin}, {"anchors", {{"1", is_geodetic ? by_local : by_ecef}}}},
                     {{"position", &block}},
                     without({"range", "anchor"})});
    Complaints out;
    const Measured m = linearize(*model, sample, ports, {}, out);
    REQUIRE_NO_COMPLAINTS(out);
    CHECK(std::abs(m.residual[0] - 1) < 1e-8);
    CHECK((m.H[0] - Eigen::RowVector3d(-0.6, 0.8, 0)).norm() < 1e-3);
    REQUIRE_NO_COMPLAINTS(check_measurement(*model, Range::spec(), sample, ports, {}, {1e-6}, 1e-8));
  }
}

TEST_CASE("range: a row's own noise wins, and where it has none the config's holds", "[aiding]") {
  const AdditiveKind position(3, "m");
  const PortStates ports{{&position, {3, 4, 12}, 1.0, 1e-9}, {}};
  const auto variances = [&](const std::string& field, const nlohmann::json& parameters, double value) {
    const auto model = bind<Range>({parameters, {{"position", &position}}, without({"range", "anchor", field})});
    Complaints out;
    return linearize(*model,
                     Rows({{{"range", 13}, {"anchor", 105}, {field, value}},
                           {{"range", 13}, {"anchor", 107}},
                           {{"range", 13}, {"anchor", 109}}}),
                     ports, {}, out);
  };
  const nlohmann::json with_sigma{{"anchors", three}, {"sigma", 0.1}}, without_sigma{{"anchors", three}};
  Measured m = variances("range_sd", with_sigma, 0.2);
  CHECK(m.R.diagonal().isApprox(Vector3d(0.04, 0.01, 0.09)));
  m = variances("range_variance", with_sigma, 0.2);
  CHECK(m.R.diagonal().isApprox(Vector3d(0.2, 0.01, 0.09)));
  m = variances("range_variance", without_sigma, 0.2);
  CHECK(m.R.diagonal().isApprox(Eigen::Vector2d(0.2, 0.09)));  // of the second nobody knows
  CHECK(m.keys == std::vector<std::int64_t>{105, 109});
  m = variances("range_sd", with_sigma, 0);
  CHECK(m.keys == std::vector<std::int64_t>{107, 109});
}

TEST_CASE("range: rows that cannot be used are left out, and the others are not", "[aiding]") {
  const AdditiveKind position(3, "m");
  const auto model =
      bind<Range>({{{"sigma", 0.1}, {"anchors", three}}, {{"position", &position}}, without({"range", "anchor"})});
  const auto keys = [&](const std::vector<Row>& rows, std::vector<double> at = {3, 4, 12}) {
    Complaints out;
    const Measured m = linearize(*model, Rows(rows), {{&position, std::move(at), 1.0, 1e-9}, {}}, {}, out);
    REQUIRE_NO_COMPLAINTS(out);
    if (!m.result) REQUIRE(m.result.refusal == Refusal::unsupported);
    return m.result ? m.keys : std::vector<std::int64_t>{};
  };
  const Row good{{"range", 13}, {"anchor", 107}};
  using Keys = std::vector<std::int64_t>;
  CHECK(keys({good}) == Keys{107});
  CHECK(keys({{{"range", NAN}, {"anchor", 105}}, good}) == Keys{107});
  CHECK(keys({{{"range", 13}, {"anchor", 106}}, good}) == Keys{107});
  CHECK(keys({{{"range", 13}, {"anchor", 105.5}}, good}) == Keys{107});
  CHECK(keys({{{"range", 13}, {"anchor", NAN}}, good}) == Keys{107});
  CHECK(keys({good, good}) == Keys{107});
  CHECK(keys({{{"range", 13}, {"anchor", 105}}, good}, {0, 0, 0}) == Keys{107});  // at anchor 105
  CHECK(keys({{{"range", INFINITY}, {"anchor", 105}}}).empty());
  CHECK(keys({}).empty());

  const auto by_rows = bind<Range>({{{"sigma", 0.1}, {"max_rows", 2}},
                                    {{"position", &position}},
                                    without({"range", "anchor", "anchor_north", "anchor_east", "anchor_down"})});
  const auto row = [](double key, double north) {
    return Row{{"range", 5}, {"anchor", key}, {"anchor_north", north}, {"anchor_east", 0}, {"anchor_down", 0}};
  };
  Complaints out;
  const Measured m = linearize(*by_rows, Rows({row(1, NAN), row(2, 7), row(3, 8), row(4, 9)}),
                               {{&position, {3, 4, 12}, 1.0, 1e-9}, {}}, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  CHECK(m.keys == Keys{2, 3});
}

TEST_CASE("range: what does not fit is refused when it is bound", "[aiding]") {
  const AdditiveKind position(3, "m"), speed(3, "m/s"), two(2, "m");
  const PositionKind geodetic;
  const std::vector<std::string> plain = without({"range", "anchor"});
  const Ports local{{"position", &position}}, on_earth{{"position", &geodetic}};
  const nlohmann::json good{{"anchors", three}, {"sigma", 1}};
  CHECK(refusal_of<Range>({good, local, plain}).empty());
  CHECK(says(refusal_of<Range>({good, {{"position", &speed}}, plain}),
             "/blocks/position: a place is of the kind 'position'"));
  CHECK(says(refusal_of<Range>({good, on_earth, plain}),
             "/anchors/105: local points (north, east, down) for a place on the earth need an origin"));
  CHECK(says(refusal_of<Range>({{{"anchors", {{"1", {{"x", 1}, {"y", 2}, {"z", 3}}}}}, {"sigma", 1}}, local, plain}),
             "/anchors/1: points on the earth for a local place need an origin"));
  CHECK(says(refusal_of<Range>({{{"anchors", {{"1", {{"north", 1}, {"east", 2}}}}}, {"sigma", 1}}, local, plain}),
             "/anchors/1: missing key 'down': a point is north, east, down"));
  CHECK(refusal_of<Range>(
            {{{"anchors", {{"1", {{"north", 1}, {"east", 2}}}}}, {"sigma", 1}}, {{"position", &two}}, plain})
            .empty());
  const nlohmann::json twice{{"lat", 1}, {"lon", 1}, {"height", 1}, {"x", 1}, {"y", 1}, {"z", 1}};
  CHECK(says(refusal_of<Range>({{{"anchors", {{"1", twice}}}, {"sigma", 1}}, on_earth, plain}),
             "/anchors/1: the point is given twice: by lat, lon, height and by x, y, z"));
  CHECK(says(refusal_of<Range>(
                 {{{"anchors", {{"door", {{"north", 1}, {"east", 2}, {"down", 3}}}}}, {"sigma", 1}}, local, plain}),
             "/anchors/door: an anchor is listed by its whole number"));
  CHECK(says(refusal_of<Range>({{{"sigma", 1}}, local, plain}), "/anchors: the positions of the anchors are missing"));
  CHECK(says(refusal_of<Range>({{{"anchors", three}}, local, plain}), ": missing key 'sigma'"));
  CHECK(says(refusal_of<Range>({good, local, without({"range"})}), "/fields: the channel carries no field 'anchor'"));
  CHECK(says(refusal_of<Range>({good, local, without({"range", "anchor", "anchor_north", "anchor_east"})}),
             "/fields: the channel carries only part of the anchors' positions, without a field for 'anchor_down'"));
  CHECK(
      says(refusal_of<Range>({good, local, without({"range", "anchor", "anchor_north", "anchor_east", "anchor_down"})}),
           "/anchors/105: the channel carries the anchors' positions: remove them here, or there"));
  CHECK(says(refusal_of<Range>({good, local, without({"range", "anchor", "range_sd", "range_variance"})}),
             "/fields: the channel carries both"));
  CHECK(says(refusal_of<Range>({good, {{"position", &position}, {"bias", &two}}, plain}),
             "/blocks/bias: its block has 2 components where 'anchors' lists 3"));
}

}  // namespace range_test
