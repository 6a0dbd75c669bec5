// SPDX-License-Identifier: Apache-2.0
// Noise estimators on simulated innovations whose covariance is known: what they find, what bounds them, what they keep.
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Dense>
#include <nlohmann/json.hpp>

#include "adaptive_noise/beta_adapter.hpp"
#include "adaptive_noise/innovation_window.hpp"
#include "adaptive_noise/sage_husa.hpp"
#include "binnacle/bind.hpp"
#include "binnacle/testing.hpp"
#include "catch.hpp"
#include "random/normal.hpp"

namespace adaptive_noise_test {

using namespace binnacle;
using namespace binnacle::adaptive_noise;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

using Json = nlohmann::ordered_json;

/// The paper's two groups: rows 0 and 1, rows 2 to 4.
NoiseBinding alignment() { return {5, {{"velocity.velocity", "m/s"}, {"attitude.attitude", "rad"}}}; }
NoiseBinding single(int rows) { return {rows, {{"rows", "m"}}}; }

template <class Estimator>
std::unique_ptr<Estimator> make(const Json& config, const NoiseBinding& noise) {
  return binnacle::testing::bind<Estimator>({.parameters = config, .noise = noise});
}

/// An estimator with its memory, used as the kernel uses it.
class Bench {
 public:
  Bench(std::shared_ptr<const NoiseEstimator> estimator, NoiseBinding binding)
      : estimator_(std::move(estimator)), binding_(std::move(binding)) {
    restart();
  }

  void restart() { memory_ = binnacle::testing::NoiseCaller(*estimator_).fresh_memory(); }
  /// R for these residuals; then what follows an update with it.
  MatrixXd offer(const VectorXd& residual, const MatrixXd& HPHt, const MatrixXd& nominal,
                 const std::vector<std::int64_t>& keys = {}) {
    binnacle::testing::InnovationNumbers innovation{residual, HPHt, nominal};
    innovation.keys = keys;
    const bool is_alignment = binding_.groups.size() == 2;
    for (int row = 0; row < residual.size(); ++row) innovation.groups.push_back(is_alignment && row >= 2 ? 1 : 0);
    const auto estimated = binnacle::testing::NoiseCaller(*estimator_).estimate(innovation, memory_.data());
    REQUIRE(estimated.damage.empty());
    return estimated.R;
  }
  std::vector<std::byte>& memory() { return memory_; }

 private:
  std::shared_ptr<const NoiseEstimator> estimator_;
  NoiseBinding binding_;
  std::vector<std::byte> memory_;
};

template <class Estimator>
Bench bench(const Json& config, const NoiseBinding& noise) {
  return Bench(make<Estimator>(config, noise), noise);
}

/// Innovations N(0, HPHᵀ + R).
class Innovations {
 public:
  Innovations(const MatrixXd& S, std::uint64_t seed = 1)
      : root_(S.llt().matrixL()), stream_(random::stream(seed, "r")) {}
  VectorXd next() {
    VectorXd w(root_.rows());
    for (auto& element : w) element = random::normal(stream_);
    return root_ * w;
  }

 private:
  MatrixXd root_;
  random::Philox stream_;
};

MatrixXd diagonal(std::initializer_list<double> sigmas) {
  VectorXd v(static_cast<long>(sigmas.size()));
  long i = 0;
  for (const double sigma : sigmas) v[i++] = sigma * sigma;
  return v.asDiagonal();
}

/// Of a variance found as a mean of n squares with variance S, less a known part: 4.5 σ.
bool is_variance(double found, double R, double S, double n) {
  return std::abs(found - R) < 4.5 * S * std::sqrt(2.0 / n);
}

constexpr double arcmin = std::numbers::pi / 10800;

}  // namespace

// ---- beta_adapter

TEST_CASE("adaptive noise: beta finds the noise of each group of a stack") {
  const double v = 0.257 * 1.7, a = 0.2 * arcmin * 0.4;
  const MatrixXd nominal = diagonal({0.257, 0.257, 0.2 * arcmin, 0.2 * arcmin, 0.2 * arcmin});
  const MatrixXd truth = diagonal({v, v, a, a, a}), HPHt = 0.3 * truth;
  for (const Json& config : {Json{{"window", 1000}},
                             Json{{"window", 1000}, {"r2", {{"velocity", "1 m/s"}, {"attitude.attitude", "1 rad"}}}}}) {
    Bench filter = bench<BetaAdapter>(config, alignment());
    Innovations innovations(HPHt + truth);
    MatrixXd R;
    for (int i = 0; i < 1000; ++i) {
      R = filter.offer(innovations.next(), HPHt, nominal);
      if (i < 999) REQUIRE(R == nominal);  // "start": "nominal"
    }
    INFO(R);
    REQUIRE(is_variance(R(0, 0), v * v, 1.3 * v * v, 2000));
    REQUIRE(is_variance(R(3, 3), a * a, 1.3 * a * a, 3000));
    REQUIRE(R(0, 0) == R(1, 1));
    REQUIRE(std::abs(R(2, 2) / R(4, 4) - 1) < 1e-12);
    REQUIRE(R(0, 1) == 0.0);
  }
}

TEST_CASE("adaptive noise: beta is divided by the rows it is fitted to") {
  // Paper 000 (20) and (26) have tr[M − L1] alone: three times as much for three rows.
  Bench filter =
      bench<BetaAdapter>({{"window", 2}, {"start", "literal"}, {"r1", {{"rows", "0.1 m"}}}, {"r2", {{"rows", "1 m"}}}},
                         single(3));
  const MatrixXd HPHt = diagonal({0.5, 0.6, 0.7}), nominal = MatrixXd::Identity(3, 3);
  filter.offer(Eigen::Vector3d(2, -1, 3), HPHt, nominal);
  const MatrixXd R = filter.offer(Eigen::Vector3d(4, 5, -1), HPHt, nominal);
  const double trace = (4.0 + 16) / 2 + (1.0 + 25) / 2 + (9.0 + 1) / 2 - (0.25 + 0.36 + 0.49) - 3 * 0.01;
  for (int i = 0; i < 3; ++i) REQUIRE(std::abs(R(i, i) - (0.01 + trace / 3)) < 1e-12);
}

TEST_CASE("adaptive noise: beta by component, and with a shape that is not one number") {
  const MatrixXd HPHt = diagonal({0.5, 0.6}), nominal = diagonal({1, 3});
  const Eigen::Vector2d r(2, 7);
  const MatrixXd each =
      bench<BetaAdapter>({{"window", 1}, {"per", "component"}, {"r1_factor", 0}}, single(2)).offer(r, HPHt, nominal);
  REQUIRE(std::abs(each(0, 0) - (4 - 0.25)) < 1e-12);
  REQUIRE(std::abs(each(1, 1) - (49 - 0.36)) < 1e-12);
  const MatrixXd group = bench<BetaAdapter>({{"window", 1}, {"r1_factor", 0.5}}, single(2)).offer(r, HPHt, nominal);
  const double beta = (1 * (4 - 0.25 - 0.25) + 9 * (49 - 0.36 - 0.25 * 9)) / (1 + 81);  // (19) with R2 = diag(1, 9)
  REQUIRE(std::abs(group(0, 0) - (0.25 + beta)) < 1e-12);
  REQUIRE(std::abs(group(1, 1) - 9 * (0.25 + beta)) < 1e-12);
}

TEST_CASE("adaptive noise: at the start the literal beta falls to R1, nominal and hold do not") {
  const MatrixXd nominal = diagonal({0.2, 0.2, 0.2}), HPHt = 1e4 * nominal;
  Innovations innovations(HPHt);
  const auto first = [&](const Json& config) {
    Bench filter = bench<BetaAdapter>(config, single(3));
    Innovations same = innovations;
    VectorXd r = same.next();
    while (r.squaredNorm() > HPHt.trace()) r = same.next();
    return filter.offer(r, HPHt, nominal);
  };
  REQUIRE((first({{"start", "literal"}}) - 1e-6 * nominal).norm() < 1e-18);
  REQUIRE(first({{"start", "nominal"}}) == nominal);
  REQUIRE((first({{"start", "literal"}, {"hold", true}}) - nominal).norm() < 1e-15);
}

TEST_CASE("adaptive noise: a held beta is the last one that was not negative") {
  const MatrixXd nominal = diagonal({1}), small = diagonal({0.5}), large = diagonal({9});
  Bench filter = bench<BetaAdapter>({{"window", 1}, {"hold", true}, {"r1_factor", 0}}, single(1));
  const auto offer = [&](double r, const MatrixXd& HPHt) {
    return filter.offer(VectorXd::Constant(1, r), HPHt, nominal)(0, 0);
  };
  REQUIRE(std::abs(offer(2, small) - 3.75) < 1e-14);
  REQUIRE(std::abs(offer(2, large) - 3.75) < 1e-14);
  REQUIRE(std::abs(offer(10, large) - 19) < 1e-12);
  Bench clipped = bench<BetaAdapter>({{"window", 1}, {"r1_factor", 0}}, single(1));
  REQUIRE(clipped.offer(VectorXd::Constant(1, 2), large, nominal)(0, 0) == 0.0);
}

TEST_CASE("adaptive noise: one beta over metres a second and radians in SI makes nonsense of the attitude") {
  const double v = 0.257, a = 0.2 * arcmin;
  const MatrixXd truth = diagonal({v, v, a, a, a}), HPHt = 0.3 * truth;
  const auto found = [&](const Json& config) {
    Bench filter = bench<BetaAdapter>(config, alignment());
    Innovations innovations(HPHt + truth);
    MatrixXd R;
    for (int i = 0; i < 200; ++i) R = filter.offer(innovations.next(), HPHt, truth);
    return R;
  };
  const Json si = {{"velocity", "1 m/s"}, {"attitude", "1 rad"}};
  REQUIRE(found({{"per", "one"}, {"window", 200}, {"r2", si}})(4, 4) > 1e6 * a * a);
  REQUIRE(is_variance(found({{"per", "group"}, {"window", 200}, {"r2", si}})(4, 4), a * a, 1.3 * a * a, 600));
}

TEST_CASE("adaptive noise: beta refuses a group that is not there, and one in another unit") {
  const auto pointer_of = [](const Json& config) -> std::string {
    try {
      make<BetaAdapter>(config, alignment());
    } catch (const ComponentError& error) {
      return error.pointer();
    }
    return "accepted";
  };
  REQUIRE(pointer_of({{"r1", {{"speed", "1 m/s"}}}}) == "/r1/speed");
  REQUIRE(pointer_of({{"r2", {{"attitude", "1 m/s"}}}}) == "/r2/attitude");
  REQUIRE(pointer_of({{"r2", {{"attitude", "0.2 arcmin"}}}}) == "accepted");
  REQUIRE(pointer_of({{"floor", 2}, {"ceiling", 1}}) == "/ceiling");
}

// ---- the others

TEST_CASE("adaptive noise: each estimator finds the noise, within the scatter that its memory leaves") {
  const MatrixXd nominal = diagonal({1, 2, 0.5}), truth = diagonal({2, 1.5, 1.2}), HPHt = 0.4 * nominal;
  const Json windows[] = {{{"window", 3000}, {"from", "innovation"}},
                          {{"window", 3000}, {"from", "residual"}},
                          {{"window", 3000}, {"from", "innovation"}, {"shape", "full"}},
                          {{"window", 3000}, {"from", "residual"}, {"shape", "full"}}};
  const auto check = [&](Bench filter, const char* name, int rounds) {
    Innovations innovations(HPHt + truth, 7);
    MatrixXd R;
    for (int i = 0; i < rounds; ++i) R = filter.offer(innovations.next(), HPHt, nominal);
    INFO(name << "\n" << R);
    REQUIRE((R - R.transpose()).norm() < 1e-12);
    for (int i = 0; i < 3; ++i)  // the residual's estimate moves by (R/S)² of what is wrong with it: a wider band
      REQUIRE(is_variance(R(i, i), truth(i, i), 2 * (HPHt(i, i) + truth(i, i)), 3000));
    REQUIRE(std::abs(R(0, 1)) < 4.5 * std::sqrt(truth(0, 0) * truth(1, 1)) * 1.7 / std::sqrt(3000));
  };
  for (const Json& config : windows) check(bench<InnovationWindow>(config, single(3)), config.dump().c_str(), 40000);
  check(bench<SageHusa>({{"forgetting", 1}}, single(3)), "innovation", 3000);
  check(bench<SageHusa>({{"forgetting", 1}, {"from", "residual"}}, single(3)), "residual", 100000);
  check(bench<BetaAdapter>({{"window", 3000}, {"per", "component"}}, single(3)), "beta", 3000);
}

TEST_CASE("adaptive noise: the full shape finds correlations, the diagonal keeps the nominal ones") {
  MatrixXd truth(2, 2), nominal(2, 2);
  truth << 4, 1.8, 1.8, 1;
  nominal << 1, -0.2, -0.2, 1;
  const MatrixXd HPHt = 0.2 * truth;
  const auto found = [&](const char* shape, const char* from) {
    Bench filter = bench<InnovationWindow>({{"window", 2000}, {"shape", shape}, {"from", from}}, single(2));
    Innovations innovations(HPHt + truth, 3);
    MatrixXd R;
    for (int i = 0; i < 20000; ++i) R = filter.offer(innovations.next(), HPHt, nominal);
    return R;
  };
  for (const char* from : {"innovation", "residual"}) {
    const MatrixXd R = found("full", from);
    INFO(R);
    REQUIRE(is_variance(R(0, 0), 4, 4.8 * 1.5, 2000));
    REQUIRE(std::abs(R(1, 0) - 1.8) < 4.5 * std::sqrt(4.8 * 1.2 + 2.16 * 2.16) / std::sqrt(2000.0) * 1.5);
    const MatrixXd D = found("diagonal", from);
    REQUIRE(std::abs(D(1, 0) / std::sqrt(D(0, 0) * D(1, 1)) + 0.2) < 1e-12);
    // A gain made with the wrong correlations leaves a residual that is not what "residual" takes it for.
    if (std::string(from) == "innovation") REQUIRE(is_variance(D(1, 1), 1, 1.2 * 1.5, 2000));
  }
}

TEST_CASE("adaptive noise: floor and ceiling bound every estimator, and R stays positive definite") {
  const MatrixXd nominal = diagonal({1, 2, 0.5});
  const auto bounded = [&](const std::function<Bench()>& make_bench) {
    for (const double size : {0.0, 1e-3, 1.0, 1e3}) {
      Bench filter = make_bench();
      Innovations innovations(MatrixXd(size * size * nominal + 1e-12 * MatrixXd::Identity(3, 3)), 5);
      for (int i = 0; i < 60; ++i) {
        const MatrixXd R = filter.offer(innovations.next(), 0.9 * nominal, nominal);
        const MatrixXd root = nominal.diagonal().cwiseSqrt().cwiseInverse().asDiagonal();
        const VectorXd sigmas = (root * R * root).eval().selfadjointView<Eigen::Lower>().eigenvalues().cwiseSqrt();
        INFO("size " << size << ", sample " << i << "\n" << sigmas);
        REQUIRE(sigmas.minCoeff() > 0.5 - 1e-9);
        REQUIRE(sigmas.maxCoeff() < 3 + 1e-9);
        if (i == 59 && size < 0.1) REQUIRE(sigmas.minCoeff() < 0.98);
        if (i == 59 && size > 100) REQUIRE(sigmas.maxCoeff() > 3 - 1e-9);
      }
    }
  };
  const auto with = [](Json config) {
    config["floor"] = 0.5;
    config["ceiling"] = 3;
    return config;
  };
  for (const char* per : {"group", "component", "one"})
    for (const char* start : {"literal", "nominal"})
      bounded([&] { return bench<BetaAdapter>(with({{"window", 20}, {"per", per}, {"start", start}}), single(3)); });
  for (const char* from : {"innovation", "residual"}) {
    bounded([&] { return bench<SageHusa>(with({{"from", from}, {"forgetting", 0.9}}), single(3)); });
    for (const char* shape : {"diagonal", "full"})
      bounded([&] {
        return bench<InnovationWindow>(with({{"window", 20}, {"from", from}, {"shape", shape}}), single(3));
      });
  }
}

TEST_CASE("adaptive noise: while the state is unknown nothing is learnt") {
  const MatrixXd nominal = diagonal({1}), unknown = diagonal({100}), known = diagonal({0.3});
  for (const bool is_window : {true, false}) {
    Bench filter = is_window ? bench<InnovationWindow>({{"window", 10}, {"from", "innovation"}}, single(1))
                             : bench<SageHusa>(Json::object(), single(1));
    for (int i = 0; i < 50; ++i) REQUIRE(filter.offer(VectorXd::Constant(1, 300.0), unknown, nominal) == nominal);
    MatrixXd R;
    for (int i = 0; i < 300; ++i) R = filter.offer(VectorXd::Constant(1, i % 2 ? 1.5 : -1.5), known, nominal);
    REQUIRE(std::abs(R(0, 0) - (2.25 - 0.09)) < 0.05);
  }
}

TEST_CASE("adaptive noise: a forgetting factor forgets at its rate") {
  Bench filter = bench<SageHusa>({{"forgetting", 0.9}, {"floor", 0}}, single(1));
  const MatrixXd none = MatrixXd::Zero(1, 1), nominal = MatrixXd::Identity(1, 1);
  double expected = 1, weight = 1;
  for (int k = 1; k < 40; ++k) {
    const double r = k % 3;
    const double d = (1 - 0.9) / (1 - std::pow(0.9, k + 1));
    expected = (1 - d) * expected + d * r * r;
    weight = 0.9 * weight + 1;
    REQUIRE(std::abs(filter.offer(VectorXd::Constant(1, r), none, nominal)(0, 0) - expected) < 1e-12);
  }
}

// ---- memory

TEST_CASE("adaptive noise: all that is remembered is in the memory") {
  const MatrixXd nominal = diagonal({1, 2, 0.5}), HPHt = 0.4 * nominal;
  const auto check = [&](const std::function<Bench()>& make_bench) {
    Bench one = make_bench(), other = make_bench();
    Innovations innovations(HPHt + nominal, 2), strangers(9 * nominal, 3);
    for (int i = 0; i < 37; ++i)
      one.offer(innovations.next(), HPHt, nominal), other.offer(strangers.next(), HPHt, nominal);
    other.memory() = one.memory();
    for (int i = 0; i < 37; ++i) {
      const VectorXd r = innovations.next();
      REQUIRE(one.offer(r, HPHt, nominal) == other.offer(r, HPHt, nominal));
    }
    const auto size = one.memory().size();
    one.restart();
    REQUIRE(one.memory().size() == size);
    REQUIRE(one.offer(Eigen::Vector3d(1, 1, 1), HPHt, nominal) ==
            make_bench().offer(Eigen::Vector3d(1, 1, 1), HPHt, nominal));
  };
  check([] { return bench<BetaAdapter>({{"window", 10}, {"hold", true}}, single(3)); });
  for (const char* from : {"innovation", "residual"}) {
    check([&] { return bench<SageHusa>({{"from", from}}, single(3)); });
    check([&] { return bench<InnovationWindow>({{"window", 10}, {"from", from}, {"shape", "full"}}, single(3)); });
  }
}

TEST_CASE("adaptive noise: a row is known by its key, not by its place") {
  const MatrixXd nominal = MatrixXd::Identity(2, 2), HPHt = 0.1 * nominal;
  const auto check = [&](Bench filter) {
    MatrixXd R;
    // satellite 7 is noisy; satellites 11 … come and go
    for (std::int64_t i = 0; i < 200; ++i) {
      const double sign = i % 2 ? 1 : -1;
      const std::int64_t quiet = i < 100 ? 11 : 12;
      const bool is_first = i % 3 == 0;
      Eigen::Vector2d r(sign * 5, sign);
      if (!is_first) r.reverseInPlace();
      R = filter.offer(r, HPHt, nominal,
                       is_first ? std::vector<std::int64_t>{7, quiet} : std::vector<std::int64_t>{quiet, 7});
      if ((i > 40 && i < 100) || i > 140) {
        INFO(i << "\n" << R);
        REQUIRE(std::abs(R(is_first ? 0 : 1, is_first ? 0 : 1) - 24.9) < 1.5);
        REQUIRE(std::abs(R(is_first ? 1 : 0, is_first ? 1 : 0) - 0.9) < 0.2);
      }
    }
  };
  check(bench<BetaAdapter>({{"window", 20}, {"per", "component"}}, single(2)));
  check(bench<InnovationWindow>({{"window", 20}, {"from", "innovation"}}, single(2)));
  check(bench<InnovationWindow>({{"window", 20}, {"from", "innovation"}}, single(5)));
  check(bench<SageHusa>({{"forgetting", 0.9}}, single(2)));
}

TEST_CASE("adaptive noise: their examples are accepted") {
  make<BetaAdapter>(Json::parse(BetaAdapter::spec().example), single(2));
  make<SageHusa>(Json::parse(SageHusa::spec().example), single(2));
  make<InnovationWindow>(Json::parse(InnovationWindow::spec().example), single(2));
}

}  // namespace adaptive_noise_test
