// SPDX-License-Identifier: Apache-2.0
// Which form of the covariance survives what, and what each costs: `covariance_bench [STEPS [SECONDS]]`. Each world starts with a
// variance of P0 next to a noise of R, and makes STEPS steps and updates; the largest error of a sigma on the way is relative to
// a reference with a hundred digits. The costs are of an INS in a session, as ratios to joseph's, SECONDS for each figure.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include "base/aligned.hpp"
#include "binnacle/session.hpp"
#include "filter/covariance_form.hpp"
#include "ins_config.hpp"

using namespace binnacle;
using namespace binnacle::internal::filter;
using Eigen::MatrixXd;

namespace {

using Exact = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<100>, boost::multiprecision::et_off>;
using Clock = std::chrono::steady_clock;

constexpr CovarianceKind kinds[] = {CovarianceKind::joseph, CovarianceKind::ud, CovarianceKind::square_root};
constexpr double noise = 1e-6;  // R: a filter stops at a variance of 1e30

struct World {
  const char* name;
  MatrixXd Phi, Q, H, R;
  int n() const { return static_cast<int>(Phi.rows()); }
  int m() const { return static_cast<int>(H.rows()); }
};

/// A position and its velocity.
World moving(const char* name, const MatrixXd& H, const MatrixXd& R) {
  const double dt = 0.1, q = 1e-6;
  MatrixXd Phi = MatrixXd::Identity(2, 2), Q(2, 2);
  Phi(0, 1) = dt;
  Q << dt * dt * dt / 3, dt * dt / 2, dt * dt / 2, dt;
  return {name, Phi, q * Q, H, R};
}

std::vector<World> worlds() {
  const MatrixXd one = (MatrixXd(1, 2) << 1, 0).finished(), two = (MatrixXd(2, 2) << 1, 0, 1, 0).finished();
  const MatrixXd correlated = (MatrixXd(2, 2) << 1, 0.5, 0.5, 1).finished();
  const MatrixXd sums = (MatrixXd(3, 3) << 1, 1, 0, 0, 1, 1, 1, 0, 1).finished();
  return {moving("position seen", one, noise * MatrixXd::Identity(1, 1)),
          moving("seen twice at once", two, noise * correlated),
          {"sums of constants", MatrixXd::Identity(3, 3), MatrixXd::Zero(3, 3), sums,
           noise * MatrixXd::Identity(3, 3)}};
}

// ---- the reference

class Matrix {
 public:
  Matrix(int rows, int cols) : rows_(rows), cols_(cols), data_(static_cast<std::size_t>(rows * cols), Exact(0)) {}
  explicit Matrix(const MatrixXd& A) : Matrix(static_cast<int>(A.rows()), static_cast<int>(A.cols())) {
    for (int i = 0; i < rows_; ++i)
      for (int j = 0; j < cols_; ++j) (*this)(i, j) = A(i, j);
  }
  Exact& operator()(int i, int j) { return data_[static_cast<std::size_t>(i + j * rows_)]; }
  const Exact& operator()(int i, int j) const { return data_[static_cast<std::size_t>(i + j * rows_)]; }
  int rows() const { return rows_; }
  int cols() const { return cols_; }

  Matrix operator*(const Matrix& other) const {
    Matrix product(rows_, other.cols_);
    for (int i = 0; i < rows_; ++i)
      for (int j = 0; j < other.cols_; ++j)
        for (int k = 0; k < cols_; ++k) product(i, j) += (*this)(i, k) * other(k, j);
    return product;
  }
  Matrix plus(const Matrix& other, const Exact& factor = 1) const {
    Matrix sum = *this;
    for (std::size_t i = 0; i < data_.size(); ++i) sum.data_[i] += factor * other.data_[i];
    return sum;
  }
  Matrix transposed() const {
    Matrix turned(cols_, rows_);
    for (int i = 0; i < rows_; ++i)
      for (int j = 0; j < cols_; ++j) turned(j, i) = (*this)(i, j);
    return turned;
  }
  /// Of a positive definite matrix, by Gauss and Jordan.
  Matrix inverse() const {
    Matrix A = *this, B(MatrixXd::Identity(rows_, rows_));
    for (int k = 0; k < rows_; ++k) {
      const Exact pivot = A(k, k);
      for (int j = 0; j < rows_; ++j) A(k, j) /= pivot, B(k, j) /= pivot;
      for (int i = 0; i < rows_; ++i) {
        if (i == k) continue;
        const Exact factor = A(i, k);
        for (int j = 0; j < rows_; ++j) A(i, j) -= factor * A(k, j), B(i, j) -= factor * B(k, j);
      }
    }
    return B;
  }

 private:
  int rows_, cols_;
  std::vector<Exact> data_;
};

bool is_looked_at(int step, int steps) {
  if (step <= 100 || step == steps) return true;
  int power = 100;
  while (power < step) power *= 10;
  return power == step;
}

/// The sigmas by step: as information, P⁻ ¹ ← P⁻¹ + Hᵀ R⁻¹ H, until they change no more; of constants in one go.
class Reference {
 public:
  Reference(const World& world, double prior)
      : world_(world), P0_(MatrixXd(prior * MatrixXd::Identity(world.n(), world.n()))) {
    const Matrix H(world.H);
    information_ = std::make_unique<Matrix>(H.transposed() * Matrix(world.R).inverse() * H);
    if (is_constant()) return;
    const Matrix Phi(world.Phi), Q(world.Q);
    Matrix P = P0_;
    for (int step = 0; step < 20000; ++step) {
      P = (Phi * P * Phi.transposed()).plus(Q).inverse().plus(*information_).inverse();
      by_step_.push_back(sigmas_of(P));
      if (step < 100) continue;
      const auto& before = by_step_[by_step_.size() - 2];
      if ((by_step_.back() - before).cwiseAbs().maxCoeff() == 0) return;
    }
    std::fprintf(stderr, "the reference of '%s' does not settle\n", world.name);
    std::exit(1);
  }
  Eigen::VectorXd sigmas(int step) const {
    if (is_constant()) return sigmas_of(P0_.inverse().plus(*information_, step).inverse());
    return by_step_[std::min(static_cast<std::size_t>(step), by_step_.size()) - 1];
  }

 private:
  bool is_constant() const { return world_.Q.isZero(); }
  static Eigen::VectorXd sigmas_of(const Matrix& P) {
    Eigen::VectorXd sigmas(P.rows());
    for (int i = 0; i < P.rows(); ++i) sigmas[i] = static_cast<double>(boost::multiprecision::sqrt(P(i, i)));
    return sigmas;
  }

  const World& world_;
  Matrix P0_;
  std::unique_ptr<Matrix> information_;
  std::vector<Eigen::VectorXd> by_step_;
};

// ---- a form in a world

/// The tables that a form works on: Φ and Qd as one dense block each.
struct Tables {
  explicit Tables(const World& world) {
    const int n = plan.n = world.n();
    if (!world.Q.isZero()) {
      RowGroup group{0, n, {}, {}};
      for (int c = 0; c < n; ++c) group.columns.push_back({c, 0, c * n});
      plan.groups = {group};
      plan.noise = {{0, 0, places(n), places(n, n), 0}};
    }
    finish(plan);
  }
  TransitionPlan plan;
};

struct Survival {
  double error = 0;
  int ended = 0;  // 0: not
};

Survival survival(CovarianceKind kind, const World& world, double prior, int steps, const Reference& reference) {
  const int n = world.n(), m = world.m();
  const Tables tables(world);
  internal::base::AlignedVector<double> memory(covariance_doubles(kind, n));
  const auto form = make_covariance(kind, tables.plan, n, m, memory.data());
  const MatrixXd P0 = prior * MatrixXd::Identity(n, n);
  form->set({P0.data(), n, n, n});
  const double* const phi[] = {world.Phi.data()};
  const double* const q[] = {world.Q.data()};
  MatrixXd H = world.H, R = world.R, squares(m, 3 * m), tall(padded(n), 3 * std::max(m, 3));
  Eigen::VectorXd r = Eigen::VectorXd::Zero(m), y(m);
  const auto square = [&](int k) { return squares.data() + k * m * m; };
  const auto long_one = [&](int k) { return tall.data() + k * padded(n) * std::max(m, 3); };
  const UpdateWork work{m,         m,         H.data(),  R.data(),    r.data(),    long_one(0),
                        square(0), square(1), square(2), long_one(1), long_one(2), y.data()};
  std::vector<int> columns;
  for (int c = 0; c < n; ++c) columns.push_back(c);
  Survival found;
  for (int step = 1; step <= steps; ++step) {
    form->predict(phi, q);
    form->project(columns, work);
    if (form->factor(columns, work)) return {found.error, step};
    form->gain({}, work);
    form->correct({}, work);
    if (!form->is_below(1e30)) return {found.error, step};
    if (!is_looked_at(step, steps)) continue;
    const Eigen::VectorXd expected = reference.sigmas(step);
    for (int i = 0; i < n; ++i)
      found.error = std::max(found.error, std::abs(std::sqrt(form->variance(i)) / expected[i] - 1));
  }
  return found;
}

std::string text_of(const Survival& survival) {
  char text[64];
  if (survival.ended > 0)
    std::snprintf(text, sizeof text, "ends at %d", survival.ended);
  else
    std::snprintf(text, sizeof text, "%s %.0e", survival.error < 1e-3 ? "yes" : "no ", survival.error);
  return text;
}

void print_survival(int steps) {
  std::printf("Survives %d steps: the largest relative error of a sigma, below 1e-3\n\n", steps);
  std::printf("| world | P0/R | joseph | ud | square_root |\n|---|---|---|---|---|\n");
  for (const World& world : worlds())
    for (const double ratio : {1e0, 1e4, 1e8, 1e12, 1e16, 1e20, 1e24, 1e28, 1e30}) {
      const Reference reference(world, ratio * noise);
      std::printf("| %s | %.0e |", world.name, ratio);
      for (const auto kind : kinds)
        std::printf(" %s |", text_of(survival(kind, world, ratio * noise, steps, reference)).c_str());
      std::printf("\n");
      std::fflush(stdout);
    }
}

// ---- what they cost

const char* const line_config = R"({"binnacle": 1,
  "sources": {"imu": {"type": "pushed", "fields": {"a": {"unit": "m/s", "kind": "increment"}}},
              "gnss": {"type": "pushed", "fields": {"z0": {"unit": "m"}, "z1": {"unit": "m"}}}},
  "filters": {"ins": {
    "blocks": {"position": {"type": "vector", "size": 2, "unit": "m", "sigma": 5},
               "velocity": {"type": "vector", "size": 2, "unit": "m/s", "sigma": 1}},
    "process": {"move": {"type": "integrated", "blocks": {"x": "position", "rate": "velocity"}},
                "wander": {"type": "random_walk", "blocks": {"x": "velocity"}, "q": 0.1}},
    "measurements": {"fix": {"type": "linear_measurement", "channel": "gnss", "blocks": {"x": "position"},
                             "sigma": [2, 2]}}}}})";

/// Nanoseconds of processor time, the least of many batches.
template <class Act>
double least_time(double seconds, Act&& act) {
  double least = 1e300;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  do {
    constexpr int batch = 200;
    const auto begin = Clock::now();
    for (int i = 0; i < batch; ++i) act();
    least = std::min(least, std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / batch);
  } while (Clock::now() < end);
  return least;
}

struct Cost {
  double step = 0, update = 0;
};

Cost cost(CovarianceKind kind, int n, double seconds) {
  LoadOptions options;
  options.sets = {std::string("/filters/ins/covariance=") + covariance_names[static_cast<int>(kind)]};
  Session session(Composition::parse(n < 9 ? line_config : bench::ins_config(n), "bench.json", options));
  const auto gnss = session.channel("gnss");
  Time t = 0;
  constexpr Time interval = 5'000'000;
  const double increments[6] = {1e-4, -2e-4, 5e-4, 0.002, 0.001, -0.04904};
  const double position[3] = {0.8377580409572782, 0.19198621771937624, 500}, origin[2] = {0, 0};
  const std::span<const double> fix = n < 9 ? std::span<const double>(origin) : std::span<const double>(position);
  Cost found;
  if (n < 9) {  // no input: a fix later is a step and an update, one at the same time an update
    session.push(gnss, no_time, t, fix);
    found.update = least_time(seconds, [&] { session.push(gnss, no_time, t, fix); });
    found.step = least_time(seconds, [&] { session.push(gnss, no_time, t += interval, fix); }) - found.update;
  } else {
    const auto imu = session.channel("imu");
    const auto step = [&] {
      session.push(imu, t, t + interval, increments);
      t += interval;
    };
    for (int i = 0; i < 200; ++i) step();
    found.step = least_time(seconds, step);
    found.update = least_time(seconds, [&] { session.push(gnss, no_time, t, fix); });
  }
  const auto counts = session.counts(session.measurement("fix"));
  if (counts.offered == counts.by_outcome[0] && session.healthy({0})) return found;
  std::fprintf(stderr, "not every fix was accepted\n");
  std::exit(1);
}

void print_costs(double seconds) {
  std::printf("\nTimes of a session, models included, in microseconds and as a ratio to joseph's\n\n");
  std::printf("| n | | joseph | ud | square_root |\n|---|---|---|---|---|\n");
  for (const int n : {4, 15, 21}) {
    Cost costs[3];
    for (int k = 0; k < 3; ++k) costs[k] = cost(kinds[k], n, seconds);
    for (const bool is_step : {true, false}) {
      std::printf("| %d | %s |", n, is_step ? "step" : "update");
      const auto time = [&](int k) { return 1e-3 * (is_step ? costs[k].step : costs[k].update); };
      std::printf(" %.2f |", time(0));
      for (int k = 1; k < 3; ++k) std::printf(" %.2f (%.1f) |", time(k), time(k) / time(0));
      std::printf("\n");
    }
  }
}

}  // namespace

int main(int count, char* arguments[]) {
  ::setenv("BINNACLE_PLUGIN_PATH", BENCH_PLUGINS, 1);
  const int steps = count > 1 ? std::atoi(arguments[1]) : 1'000'000;
  const double seconds = count > 2 ? std::atof(arguments[2]) : 1.0;
  if (steps < 1 || !(seconds > 0)) {
    std::fprintf(stderr, "covariance_bench [STEPS [SECONDS]]\n");
    return 2;
  }
  print_survival(steps);
  print_costs(seconds);
  return 0;
}
