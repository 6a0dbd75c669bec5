// SPDX-License-Identifier: Apache-2.0
// Robust losses: weights against the losses' own formulas, their efficiency, and the fixed points against other solvers.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "binnacle/bind.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"
#include "random/normal.hpp"
#include "robust/robust_noise.hpp"

namespace robust_test {

using namespace binnacle;
using namespace binnacle::robust;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Json = nlohmann::ordered_json;

constexpr Whitened innovation = Whitened::innovation, residual = Whitened::residual;
constexpr Loss losses[] = {Loss::huber, Loss::cauchy, Loss::student_t, Loss::dcs};

std::unique_ptr<NoiseEstimator> make(Loss loss, const Json& config, int max_rows) {
  const auto bound = [&]<class Estimator>() -> std::unique_ptr<NoiseEstimator> {
    return binnacle::testing::bind<Estimator>({.parameters = config, .noise = {max_rows, {{"rows", "m"}}}});
  };
  switch (loss) {
    case Loss::huber: return bound.operator()<Huber>();
    case Loss::cauchy: return bound.operator()<Cauchy>();
    case Loss::student_t: return bound.operator()<StudentT>();
    default: return bound.operator()<DynamicCovarianceScaling>();
  }
}

binnacle::testing::Estimated estimated(const NoiseEstimator& estimator,
                                       const binnacle::testing::InnovationNumbers& in) {
  const binnacle::testing::NoiseCaller caller(estimator);
  auto memory = caller.fresh_memory();
  const auto out = caller.estimate(in, memory.data());
  REQUIRE(out.damage.empty());
  return out;
}

/// The losses themselves, up to a constant.
double cost(Loss loss, double c, int m, double d) {
  const double d2 = d * d;
  switch (loss) {
    case Loss::huber: return d <= c ? d2 / 2 : c * d - c * c / 2;
    case Loss::cauchy: return c * c / 2 * std::log(1 + d2 / (c * c));
    case Loss::student_t: return (c + m) / 2 * std::log(1 + d2 / c);
    default: return d2 <= c ? d2 / 2 : 2 * c * d2 / (c + d2) - c / 2;
  }
}

/// That of 95 %, once.
double constant_of(Loss loss, Whitened of, int m) {
  static double known[4][2][8] = {};
  double& constant = known[static_cast<int>(loss)][static_cast<int>(of)][m];
  if (constant == 0) constant = tuning_of(loss, of, 0.95, m);
  return constant;
}

class Draws {
 public:
  explicit Draws(std::uint64_t seed) : stream_(random::stream(seed, "robust")) {}
  double operator()() { return random::normal(stream_); }
  VectorXd vector(int n) {
    VectorXd v(n);
    for (auto& element : v) element = (*this)();
    return v;
  }
  MatrixXd covariance(int n) {
    MatrixXd A(n, n);
    for (auto& element : A.reshaped()) element = (*this)();
    return A * A.transpose() + 0.3 * MatrixXd::Identity(n, n);
  }

 private:
  random::Philox stream_;
};

/// Which rows share a weight, of five rows in groups 0 0 1 1 1 with the keys 7 8 7 9 8.
const std::vector<int> groups = {0, 0, 1, 1, 1};
const std::vector<std::int64_t> keys = {7, 8, 7, 9, 8};
std::vector<std::vector<int>> blocks_by(const std::string& by) {
  if (by == "sample") return {{0, 1, 2, 3, 4}};
  if (by == "part") return {{0, 1}, {2, 3, 4}};
  if (by == "key") return {{0, 2}, {1, 4}, {3}};
  return {{0}, {1}, {2}, {3}, {4}};
}

MatrixXd part(const MatrixXd& A, const std::vector<int>& rows) { return A(rows, rows); }
VectorXd part(const VectorXd& v, const std::vector<int>& rows) { return v(rows); }

/// The weight that stands in R.
double weight_in(const MatrixXd& R, const MatrixXd& nominal, int row) { return nominal(row, row) / R(row, row); }

/// R with weights by row.
MatrixXd weighted(const MatrixXd& nominal, const VectorXd& w) {
  const MatrixXd D = w.cwiseSqrt().cwiseInverse().asDiagonal();
  return D * nominal * D;
}

/// Five rows, of which the third is an outlier of `size` sigma.
binnacle::testing::InnovationNumbers five_rows(Draws& draw, double prior, double size, bool is_correlated) {
  MatrixXd R = draw.covariance(5);
  if (!is_correlated) R = MatrixXd(R.diagonal().asDiagonal());
  MatrixXd H(5, 2);
  for (auto& element : H.reshaped()) element = draw();
  binnacle::testing::InnovationNumbers in{{}, prior * H * draw.covariance(2) * H.transpose(), R};
  const MatrixXd S = in.HPHt + R;
  in.residual = S.llt().matrixL() * draw.vector(5);
  in.residual[2] += size * std::sqrt(R(2, 2));
  in.keys = keys;
  in.groups = groups;
  return in;
}

}  // namespace

// ---- the losses

TEST_CASE("robust: each weight is the derivative of its loss over the residual") {
  for (const Loss loss : losses)
    for (const int m : {1, 3, 6})
      for (const double c : {0.8, 1.7, 5.0})
        for (double d = 0.05; d < 30; d *= 1.13) {
          const double step = 1e-5 * d;
          const double slope = (cost(loss, c, m, d + step) - cost(loss, c, m, d - step)) / (2 * step);
          INFO("loss " << static_cast<int>(loss) << ", m " << m << ", constant " << c << ", d " << d);
          REQUIRE(std::abs(weight(loss, c, m, d * d) - slope / d) < 1e-6);
        }
}

TEST_CASE("robust: an update keeps 95 % of what it gains from Gaussian noise, with any number of rows") {
  constexpr int samples = 5000;
  for (const Loss loss : losses)
    for (const char* of : {"innovation", "residual"})
      for (int m = 1; m <= 6; ++m) {
        Draws draw(static_cast<std::uint64_t>(m));
        const auto estimator = make(loss, {{"of", of}}, m);
        const MatrixXd R = draw.covariance(m), P = 1e-5 * draw.covariance(m), S = P + R;
        const MatrixXd L = S.llt().matrixL(), K = P * S.inverse();
        double sum = 0, squares = 0;
        for (int k = 0; k < samples; ++k) {
          const VectorXd r = L * draw.vector(m);
          const MatrixXd Kw = P * (P + estimated(*estimator, {r, P, R}).R).inverse();
          // E[x | r] = K r, so the mean squared error is more than Kalman's by that of (K − Kw) r; in the metric of K S Kᵀ.
          const double lost = (L.inverse() * K.inverse() * (K - Kw) * r).squaredNorm() / m;
          sum += lost;
          squares += lost * lost;
        }
        const double mean = sum / samples, error = std::sqrt((squares / samples - mean * mean) / samples);
        INFO("loss " << static_cast<int>(loss) << ", " << of << ", m " << m << ": " << 1 - mean << " +- " << error);
        REQUIRE(std::abs(1 - mean - 0.95) < 4.5 * error + 1e-4);
      }
}

TEST_CASE("robust: the efficiency of a location estimate is not less, and has the usual constants") {
  // E[w d²]² / (m E[w² d²]), of one row 95 % at 1.345 and 2.385 (Holland and Welsch, table 1).
  const auto of_location = [](Loss loss, double c, int m) {
    double first = 0, second = 0, all = 0;
    const double step = 1e-3;
    for (double d = step / 2; d < std::sqrt(m) + 10; d += step) {
      const double density = std::pow(d, m - 1) * std::exp(-d * d / 2), w = weight(loss, c, m, d * d);
      all += density;
      first += w * d * d * density;
      second += w * w * d * d * density;
    }
    return first * first / (m * second * all);
  };
  REQUIRE(std::abs(of_location(Loss::huber, 1.345, 1) - 0.95) < 1e-4);
  REQUIRE(std::abs(of_location(Loss::cauchy, 2.3849, 1) - 0.95) < 1e-4);
  REQUIRE(of_location(Loss::huber, 1e-3, 10) > 0.95);  // all weights fall together: no threshold has 95 %
  for (const Loss loss : losses)
    for (const Whitened of : {innovation, residual})
      for (const int m : {1, 2, 3, 6, 12, 30}) {
        const double c = tuning_of(loss, of, 0.95, m);
        INFO("loss " << static_cast<int>(loss) << ", m " << m << ", constant " << c);
        const bool is_least = loss == Loss::student_t && c == 1.0;  // of one degree of freedom
        REQUIRE(efficiency(loss, of, c, m) > 0.95 - 1e-6);
        REQUIRE((is_least || efficiency(loss, of, c, m) < 0.95 + 1e-6));
        REQUIRE((!is_least || m > 6));
        if (of == residual) REQUIRE(of_location(loss, c, m) > 0.9499);
      }
}

TEST_CASE("robust: the settled weight is that of a state that is known") {
  for (const Loss loss : losses)
    for (const char* of : {"innovation", "residual"})
      for (double r = 0.1; r < 3000; r *= 1.3) {
        const auto R = estimated(*make(loss, {{"of", of}, {"tolerance", 1e-14}}, 1),
                                 {VectorXd::Constant(1, 2 * r), MatrixXd::Zero(1, 1), MatrixXd::Constant(1, 1, 4)})
                           .R;
        const Whitened whitened = of[0] == 'i' ? innovation : residual;
        const double w = settled_weight(loss, whitened, tuning_of(loss, whitened, 0.95, 1), 1, r * r);
        INFO("loss " << static_cast<int>(loss) << " of " << of << ", " << r);
        REQUIRE(std::abs(R(0, 0) * std::max(w, 1e-12) / 4 - 1) < 1e-10);
      }
}

// ---- of the innovation

TEST_CASE("robust: the weight by the innovation is the only fixed point") {
  Draws draw(3);
  for (int trial = 0; trial < 60; ++trial)
    for (const Loss loss : losses)
      for (const char* by : {"sample", "part", "key", "row"}) {
        const double prior = std::pow(10.0, trial % 7 - 3), size = trial % 5 == 0 ? 0 : std::pow(10.0, trial % 4);
        const auto in = five_rows(draw, prior, size, trial % 2 == 0);
        const auto R = estimated(*make(loss, {{"by", by}, {"tolerance", 1e-14}}, 5), in).R;
        VectorXd w(5);
        for (const auto& block : blocks_by(by)) {
          const int m = static_cast<int>(block.size());
          const MatrixXd M = part(in.HPHt, block), nominal = part(in.R_nominal, block);
          const VectorXd r = part(in.residual, block);
          const double c = constant_of(loss, innovation, m);
          const auto beyond = [&](double candidate) {  // falls as the candidate grows
            const double d2 = r.dot((M + nominal / candidate).ldlt().solve(r));
            return weight(loss, c, m, d2) - candidate;
          };
          double low = 1e-13, high = 10;
          int changes = 0;
          double last = beyond(low);
          for (double candidate = 1.1 * low; candidate < high; candidate *= 1.1) {
            changes += (beyond(candidate) > 0) != (last > 0);
            last = beyond(candidate);
          }
          REQUIRE(changes == 1);
          for (int i = 0; i < 120; ++i) {
            const double middle = std::sqrt(low * high);
            (beyond(middle) > 0 ? low : high) = middle;
          }
          for (const int row : block) w[row] = low;
        }
        INFO("loss " << static_cast<int>(loss) << " by " << by << ", prior " << prior << ", outlier " << size << "\n"
                     << w);
        REQUIRE((R - weighted(in.R_nominal, w))
                    .cwiseQuotient(in.R_nominal.cwiseAbs() + MatrixXd::Constant(5, 5, 1e-9))
                    .cwiseAbs()
                    .maxCoeff() < 1e-11 / w.minCoeff());
      }
}

TEST_CASE("robust: without an outlier R is the nominal one to the bit, and student_t is near it") {
  Draws draw(8);
  auto in = five_rows(draw, 1, 0, true);
  in.residual *= 0.05;
  for (const Loss loss : {Loss::huber, Loss::dcs})
    for (const char* of : {"innovation", "residual"})
      REQUIRE(estimated(*make(loss, {{"of", of}, {"by", "part"}}, 5), in).R == in.R_nominal);
  const auto R = estimated(*make(Loss::student_t, {{"dof", 4}}, 5), in).R;
  REQUIRE(weight_in(R, in.R_nominal, 0) > 2.2);  // at most (ν + m)/ν = 9/4: surer than nominal
}

TEST_CASE("robust: the larger the prior, the less a loss bites, and a gate by nominal R as well") {
  for (const Loss loss : losses)
    for (const char* of : {"innovation", "residual"}) {
      double last = 0;
      for (const double prior : {0.01, 0.1, 1.0, 10.0, 100.0, 1e4}) {
        const auto R = estimated(*make(loss, {{"of", of}}, 1),
                                 {VectorXd::Constant(1, 8), MatrixXd::Constant(1, 1, prior), MatrixXd::Identity(1, 1)})
                           .R;
        REQUIRE(1 / R(0, 0) >= last);
        last = 1 / R(0, 0);
      }
      REQUIRE(last > 0.99);
    }
}

// ---- of the residual

TEST_CASE("robust: the weights by the residual are those of iterated least squares, to 1e-12") {
  Draws draw(5);
  for (int trial = 0; trial < 40; ++trial)
    for (const Loss loss : losses)
      for (const char* by : {"sample", "part", "key", "row"}) {
        const auto in = five_rows(draw, std::pow(10.0, trial % 5 - 2), trial % 3 * 20, trial % 2 == 0);
        const auto found =
            estimated(*make(loss, {{"of", "residual"}, {"by", by}, {"tolerance", 1e-14}, {"iterations", 10000}}, 5),
                      in);
        VectorXd w = VectorXd::Ones(5);
        for (int k = 0; k < 10000; ++k) {
          const MatrixXd R = weighted(in.R_nominal, w);
          const VectorXd v = R * (in.HPHt + R).inverse() * in.residual;
          const VectorXd last = w;
          for (const auto& block : blocks_by(by)) {
            const int m = static_cast<int>(block.size());
            const double d2 = part(v, block).dot(part(in.R_nominal, block).ldlt().solve(part(v, block)));
            for (const int row : block) w[row] = weight(loss, constant_of(loss, residual, m), m, d2);
          }
          if ((w - last).cwiseAbs().maxCoeff() < 1e-15) break;
        }
        INFO("loss " << static_cast<int>(loss) << " by " << by << ", trial " << trial);
        for (int row = 0; row < 5; ++row) REQUIRE(std::abs(weight_in(found.R, in.R_nominal, row) / w[row] - 1) < 1e-10);
      }
}

TEST_CASE("robust: the update by the residual is the minimum of the loss, found by looking everywhere") {
  Draws draw(6);
  const std::vector<std::vector<int>> units[] = {blocks_by("row"), {{0, 1}, {2}, {3, 4}}};
  for (int trial = 0; trial < 30; ++trial)
    for (const Loss loss : losses) {
      const bool by_row = trial % 2 == 0;
      const VectorXd H = VectorXd::Ones(5) + 0.3 * draw.vector(5);
      MatrixXd R = MatrixXd::Zero(5, 5);
      for (const auto& block : units[by_row ? 0 : 1]) R(block, block) = draw.covariance(static_cast<int>(block.size()));
      const double P = std::pow(10.0, trial % 4 - 1);
      VectorXd r = H * std::sqrt(P) * draw() + R.llt().matrixL() * draw.vector(5);
      r[2] += 12 * std::sqrt(R(2, 2));
      binnacle::testing::InnovationNumbers in{r, P * H * H.transpose(), R};
      in.keys = {1, 1, 2, 3, 3};
      const auto found = estimated(
          *make(loss, {{"of", "residual"}, {"by", by_row ? "row" : "key"}, {"tolerance", 1e-13}, {"iterations", 10000}},
                5),
          in);
      const double delta = P * H.dot((in.HPHt + found.R).ldlt().solve(r));

      const auto whole = [&](double x) {
        double sum = x * x / P / 2;
        for (const auto& block : units[by_row ? 0 : 1]) {
          const VectorXd v = part(VectorXd(r - H * x), block);
          const int m = static_cast<int>(block.size());
          sum += cost(loss, constant_of(loss, residual, m), m, std::sqrt(v.dot(part(R, block).ldlt().solve(v))));
        }
        return sum;
      };
      double best = 0;
      for (double x = -30; x < 30; x += 0.01)
        if (whole(x) < whole(best)) best = x;
      double low = best - 0.01, high = best + 0.01;  // golden section
      for (int k = 0; k < 80; ++k) {
        const double a = high - 0.6180339887 * (high - low), b = low + 0.6180339887 * (high - low);
        (whole(a) < whole(b) ? high : low) = whole(a) < whole(b) ? b : a;
      }
      INFO("loss " << static_cast<int>(loss) << ", trial " << trial << ": " << delta << " for " << low);
      REQUIRE(std::abs(delta - low) < 1e-6);
    }
}

TEST_CASE("robust: twelve ranges outvote one though the clock is unknown, by the residual alone") {
  VectorXd r = VectorXd::Constant(12, 3e4);
  r[5] += 100;
  const binnacle::testing::InnovationNumbers in{r, MatrixXd::Constant(12, 12, 1e10), MatrixXd::Identity(12, 12)};
  for (const Loss loss : losses) {
    const auto of_residual = estimated(*make(loss, {{"of", "residual"}, {"by", "row"}}, 12), in).R;
    const auto of_innovation = estimated(*make(loss, {{"by", "row"}}, 12), in).R;
    for (int row = 0; row < 12; ++row) {
      INFO("loss " << static_cast<int>(loss) << ", row " << row);
      REQUIRE(((1 / of_residual(row, row) < 0.05) == (row == 5)));
      REQUIRE(1 / of_innovation(row, row) > 0.9);
    }
  }
}

// ---- what must not happen

TEST_CASE("robust: R stays finite, symmetric and positive semidefinite, whatever comes") {
  Draws draw(9);
  for (const Loss loss : losses)
    for (const char* of : {"innovation", "residual"})
      for (const char* by : {"sample", "part", "key", "row"})
        for (const double size : {0.0, 1e3, 1e9, 1e160, std::nan("")}) {
          const auto in = five_rows(draw, 1, size, true);
          const auto out = estimated(*make(loss, {{"of", of}, {"by", by}}, 5), in);
          INFO("loss " << static_cast<int>(loss) << " of " << of << " by " << by << ", " << size << "\n" << out.R);
          REQUIRE(out.R.allFinite());
          REQUIRE(out.R == out.R.transpose());
          const VectorXd root = out.R.diagonal().cwiseSqrt().cwiseInverse();
          REQUIRE((root.asDiagonal() * out.R * root.asDiagonal())
                      .eval()
                      .selfadjointView<Eigen::Lower>()
                      .eigenvalues()
                      .minCoeff() > 0);
          for (int i = 0; i < 5; ++i) REQUIRE(weight_in(out.R, in.R_nominal, i) > 0.99e-12);
          if (size == 0) REQUIRE(out.notes.empty());
          // Correlations stay.
          const VectorXd nominal = in.R_nominal.diagonal().cwiseSqrt().cwiseInverse();
          REQUIRE((root.asDiagonal() * out.R * root.asDiagonal() -
                   MatrixXd(nominal.asDiagonal() * in.R_nominal * nominal.asDiagonal()))
                      .norm() < 1e-12);
        }
}

TEST_CASE("robust: what there is to say becomes a note") {
  const MatrixXd one = MatrixXd::Identity(1, 1);
  const auto notes = [&](Loss loss, const Json& config, double r, double M, double R) {
    return estimated(*make(loss, config, 1), {VectorXd::Constant(1, r), M * one, R * one}).notes;
  };
  for (const char* of : {"innovation", "residual"}) {
    const auto few = notes(Loss::cauchy, {{"of", of}, {"iterations", 1}}, 30, 1, 1);
    REQUIRE(few == std::vector<std::string>{"the weights have not converged within `iterations`; the last were used"});
    REQUIRE(notes(Loss::cauchy, {{"of", of}}, 30, 1, 1).empty());
    REQUIRE(notes(Loss::dcs, {{"of", of}}, 1e12, 1, 1) ==
            std::vector<std::string>{"a weight is at its minimum, 1e-12: an extreme outlier"});
    REQUIRE(notes(Loss::dcs, {{"of", of}}, 1e9, 1, 0) ==
            std::vector<std::string>{"R of rows that share a weight is singular: they keep the weight 1"});
    REQUIRE(estimated(*make(Loss::huber, {{"of", of}}, 1), {VectorXd::Constant(1, 9), one, 0 * one}).R == 0 * one);
  }
}

TEST_CASE("robust: an efficiency and a constant of one's own are refused together") {
  for (const auto& [loss, name] : {std::pair(Loss::huber, "threshold"), std::pair(Loss::cauchy, "scale"),
                                   std::pair(Loss::student_t, "dof"), std::pair(Loss::dcs, "phi")}) {
    std::string pointer = "accepted";
    try {
      make(loss, {{name, 2}, {"efficiency", 0.9}}, 1);
    } catch (const ComponentError& error) {
      pointer = error.pointer();
    }
    REQUIRE(pointer == std::string("/") + name);
    make(loss, {{name, 2}}, 1);
    make(loss, {{"efficiency", 0.9}}, 1);
  }
}

TEST_CASE("robust: nothing is remembered, and the examples are accepted") {
  Draws draw(4);
  const auto in = five_rows(draw, 1, 30, true);
  for (const Loss loss : losses) {
    const auto estimator = make(loss, {{"of", "residual"}, {"by", "key"}}, 7);
    REQUIRE(estimator->declaration().is_judged_by_nominal);
    const binnacle::testing::NoiseCaller caller(*estimator);
    auto fresh = caller.fresh_memory(), used = fresh;
    std::ranges::fill(used, std::byte{0xff});
    REQUIRE(caller.estimate(in, fresh.data()).R == caller.estimate(in, used.data()).R);
    make(loss, Json::parse(Huber::spec().example), 2);
  }
}

}  // namespace robust_test
