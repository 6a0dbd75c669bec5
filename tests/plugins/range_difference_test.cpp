// SPDX-License-Identifier: Apache-2.0
// Plugin aiding, range_difference: the sign of each derivative, the noise that rows share, rows that bring nothing.
#include "../../plugins/aiding/range_difference.hpp"

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Eigenvalues>

#include "bind.hpp"
#include "catch.hpp"
#include "model_check.hpp"
#include "refusal.hpp"
#include "strapdown/earth.hpp"
#include "support/navigation_kinds.hpp"

namespace range_difference_test {

using namespace binnacle;
using namespace binnacle::aiding;
using namespace binnacle::test;
using Eigen::Vector3d;
using Keys = std::vector<std::int64_t>;

namespace {

/// difference, anchor, reference.
struct Rows {
  explicit Rows(std::vector<double> all) : numbers(std::move(all)) {}
  operator SampleView() const { return testing::rows_of(numbers, 3, 0); }
  std::vector<double> numbers;
};

const nlohmann::json four = {{"1", {{"north", 0}, {"east", 0}, {"down", 0}, {"sigma", 0.3}}},
                             {"2", {{"north", 30}, {"east", 0}, {"down", -4}, {"bias", 0.5}}},
                             {"3", {{"north", 0}, {"east", 40}, {"down", 5}}},
                             {"4", {{"north", 9}, {"east", 8}, {"down", -20}, {"sigma", 0.4}}}};

}  // namespace

TEST_CASE("range difference: each sign, and the noise of the common reference", "[aiding]") {
  const AdditiveKind position(3, "m"), bias(4, "m");
  const auto model = bind<RangeDifference>({{{"sigma", 0.1}, {"anchors", four}, {"reference", 1}},
                                            {{"position", &position}, {"bias", &bias}},
                                            {"reference"}});
  REQUIRE(model->declaration().max_rows == 3);
  const PortStates ports{{&position, {3, 4, 12}, 1.0, 1e-9}, {&bias, {0.1, 0.2, 0.3, 0.4}, 0.1, 1e-9}};
  const Rows sample({20, 2, NAN, 10, 4, NAN, 30, 3, NAN});
  Complaints out;
  const Measured m = linearize(*model, sample, ports, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  REQUIRE(m.result);
  CHECK(m.keys == Keys{2, 4, 3});
  const Vector3d r(3, 4, 12), to_2 = r - Vector3d(30, 0, -4), to_3 = r - Vector3d(0, 40, 5), to_4(-6, -4, 32);
  CHECK(std::abs(m.residual[0] - (20 - (to_2.norm() + 0.5 + 0.2 - 13 - 0.1))) < 1e-12);
  CHECK(std::abs(m.residual[1] - (10 - (to_4.norm() + 0.4 - 13 - 0.1))) < 1e-12);
  CHECK(std::abs(m.residual[2] - (30 - (to_3.norm() + 0.3 - 13 - 0.1))) < 1e-12);
  // Further from the anchor it grows, further from the reference it shrinks.
  CHECK(m.H[0].row(0).isApprox((to_2.normalized() - r / 13).transpose()));
  CHECK(m.H[1].row(0) == Eigen::RowVector4d(-1, 1, 0, 0));
  CHECK(m.H[1].row(1) == Eigen::RowVector4d(-1, 0, 0, 1));
  // Each has its own anchor's noise, and all have that of the reference.
  Eigen::Matrix3d R = Eigen::Matrix3d::Constant(0.09);
  R.diagonal() += Vector3d(0.01, 0.16, 0.01);
  CHECK(m.R.isApprox(R, 1e-14));
  REQUIRE_NO_COMPLAINTS(check_measurement(*model, RangeDifference::spec(), sample, ports, {}, {1e-6}, 1e-9));
}

TEST_CASE("range difference: pairs of any kind share noise with the sign that they have it in", "[aiding]") {
  const AdditiveKind position(2, "m");
  const auto model = bind<RangeDifference>({{{"sigma", 0.1}, {"anchors", four}}, {{"position", &position}}, {}});
  const PortStates ports{{&position, {3, 4}, 0.1, 1e-9}, {}};
  const auto measured = [&](const std::vector<double>& rows) {
    Complaints out;
    const Measured m = linearize(*model, Rows(rows), ports, {}, out);
    REQUIRE_NO_COMPLAINTS(out);
    REQUIRE_NO_COMPLAINTS(check_measurement(*model, RangeDifference::spec(), Rows(rows), ports, {}, {1e-6}, 1e-9));
    return m;
  };
  // 2 − 1 and 1 − 3: what 1 adds to one it takes off the other.
  Measured m = measured({1, 2, 1, 1, 1, 3});
  CHECK(m.keys == Keys{2001, 1003});
  CHECK(m.R.isApprox((Eigen::Matrix2d() << 0.1, -0.09, -0.09, 0.1).finished(), 1e-14));
  // 2 − 1 and 3 − 4 share nothing.
  m = measured({1, 2, 1, 1, 3, 4});
  CHECK(m.R.isApprox(Eigen::Vector2d(0.1, 0.17).asDiagonal().toDenseMatrix(), 1e-14));
  // A ring: the third is the sum of the others, and without it R is regular. Nor does a pair come twice, or turned round.
  m = measured({1, 2, 1, 1, 1, 3, 1, 2, 3, 1, 1, 2, 1, 2, 1, 1, 4, 1});
  CHECK(m.keys == Keys{2001, 1003, 4001});
  CHECK(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(m.R).eigenvalues().minCoeff() > 1e-3);
}

TEST_CASE("range difference: says what ranges say once their common clock is estimated", "[aiding]") {
  // z_a = |r − r_a| + c + v_a with c unknown is worth as much as the differences: both information matrices are one.
  const PositionKind geodetic;
  const Vector3d lla(0.9, 0.2, 100);
  nlohmann::json anchors;
  const std::vector<Vector3d> ways = {{300, 20, -40}, {-100, 250, 10}, {-80, -300, -90}, {40, 30, 200}, {500, 500, 0}};
  Eigen::MatrixXd by_range(5, 4);
  Eigen::VectorXd weights(5);
  const Eigen::Matrix3d C = strapdown::C_en(lla[0], lla[1]);
  std::vector<double> rows;
  for (int i = 0; i < 5; ++i) {
    const Vector3d way = ways[static_cast<std::size_t>(i)], r = strapdown::ecef_from_lla(lla) + C * way;
    const double sigma = 0.1 + 0.05 * i;
    anchors[std::to_string(i + 1)] = {{"x", r[0]}, {"y", r[1]}, {"z", r[2]}, {"sigma", sigma}};
    by_range.row(i) << -way.transpose() / way.norm(), 1;
    weights[i] = 1 / (sigma * sigma);
    if (i > 0) rows.insert(rows.end(), {way.norm() - ways[0].norm(), i + 1.0, NAN});
  }
  const auto model =
      bind<RangeDifference>({{{"anchors", anchors}, {"reference", 1}}, {{"position", &geodetic}}, {"reference"}});
  Complaints out;
  const Measured m = linearize(*model, Rows(rows), {{&geodetic, {lla[0], lla[1], lla[2]}, 1.0, 1e-8}, {}}, {}, out);
  REQUIRE_NO_COMPLAINTS(out);
  CHECK(m.residual.norm() < 1e-8);
  const Eigen::Matrix4d with_clock = by_range.transpose() * weights.asDiagonal() * by_range;
  const Eigen::Matrix3d of_differences = m.H[0].transpose() * m.R.inverse() * m.H[0];
  const Eigen::Matrix3d without_clock = with_clock.topLeftCorner<3, 3>() - with_clock.topRightCorner<3, 1>() *
                                                                               with_clock.bottomLeftCorner<1, 3>() /
                                                                               with_clock(3, 3);
  CHECK(of_differences.isApprox(without_clock, 1e-6));
}

TEST_CASE("range difference: what does not fit, and rows that cannot be used", "[aiding]") {
  const AdditiveKind position(3, "m"), two(2, "m");
  const Ports ports{{"position", &position}};
  const nlohmann::json good{{"anchors", four}, {"sigma", 1}, {"reference", 1}};
  CHECK(refusal_of<RangeDifference>({good, ports, {"reference"}}).empty());
  CHECK(says(refusal_of<RangeDifference>({good, ports, {}}),
             "/reference: the channel carries the field 'reference' too"));
  CHECK(says(refusal_of<RangeDifference>({{{"anchors", four}, {"sigma", 1}}, ports, {"reference"}}),
             ": missing key 'reference'"));
  CHECK(says(refusal_of<RangeDifference>({{{"anchors", four}, {"sigma", 1}, {"reference", 9}}, ports, {"reference"}}),
             "/reference: anchor 9 is none of 'anchors'"));
  CHECK(says(refusal_of<RangeDifference>({{{"anchors", four}, {"reference", 1}}, ports, {"reference"}}),
             ": missing key 'sigma'"));
  CHECK(says(refusal_of<RangeDifference>({{{"sigma", 1}, {"reference", 1}}, ports, {"reference"}}),
             "/anchors: no anchor is listed"));
  CHECK(says(refusal_of<RangeDifference>(
                 {{{"sigma", 1}, {"reference", 1}, {"anchors", {{"1", four["1"]}}}}, ports, {"reference"}}),
             "/anchors: a difference needs two anchors"));
  CHECK(says(refusal_of<RangeDifference>({good, {{"position", &position}, {"bias", &two}}, {"reference"}}),
             "/blocks/bias"));

  const auto model = bind<RangeDifference>({good, ports, {"reference"}});
  const auto keys = [&](const std::vector<double>& rows, std::vector<double> at = {3, 4, 12}) {
    Complaints out;
    const Measured m = linearize(*model, Rows(rows), {{&position, std::move(at), 1.0, 1e-9}, {}}, {}, out);
    REQUIRE_NO_COMPLAINTS(out);
    if (!m.result) REQUIRE(m.result.refusal == Refusal::unsupported);
    return m.result ? m.keys : Keys{};
  };
  CHECK(keys({NAN, 2, NAN, 5, 3, NAN}) == Keys{3});
  CHECK(keys({5, 7, NAN, 5, 3, NAN}) == Keys{3});
  CHECK(keys({5, 1, NAN, 5, 3, NAN}) == Keys{3});  // the reference less itself
  CHECK(keys({5, 2, NAN, 5, 3, NAN}, {30, 0, -4}) == Keys{3});
  CHECK(keys({5, 2, NAN, 5, 3, NAN}, {0, 0, 0}).empty());  // at the reference
}

}  // namespace range_difference_test
