// SPDX-License-Identifier: Apache-2.0
#include "tune/linear_log.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "algebra/decompositions.hpp"
#include "binnacle/eigen.hpp"
#include "smooth/co_states.hpp"
#include "wording/wording.hpp"

namespace binnacle::tune {

using namespace wording;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct LinearLog::Forward {
  MatrixXd P;
  VectorXd d;
  double likelihood = 0;
  std::vector<Innovation>* innovations = nullptr;
};

double* LinearLog::add(Kind kind, std::size_t doubles, int rows) {
  events_.push_back({kind, rows, false, numbers_.size()});
  numbers_.resize(numbers_.size() + doubles);
  return numbers_.data() + events_.back().at;
}

namespace {

double* keep(double* to, ConstMatrixView A) {
  MatrixView{to, A.rows, A.cols, A.rows}.as() = A.as();
  return to + A.rows * A.cols;
}

ConstMatrixView view(const MatrixXd& A) {
  return {A.data(), static_cast<int>(A.rows()), static_cast<int>(A.cols()), static_cast<int>(A.rows())};
}

}  // namespace

void LinearLog::add_start(ConstMatrixView P) { keep(add(Kind::start, as_size(n_ * n_)), P); }

void LinearLog::add_step(const MatrixXd& Phi, const MatrixXd& Qd) {
  keep(keep(add(Kind::step, as_size(2 * n_ * n_)), view(Qd)), view(Phi));
}

void LinearLog::add_update(ConstMatrixView H, ConstMatrixView R, const double* residual, const double* delta,
                           ConstMatrixView reset) {
  const int m = H.rows;
  double* to = add(Kind::update, as_size(m * m + m * n_ + m + n_ + (reset ? n_ * n_ : 0)), m);
  events_.back().has_reset = static_cast<bool>(reset);
  to = keep(keep(to, R), H);
  to = std::copy_n(residual, m, to);
  to = std::copy_n(delta, n_, to);
  if (reset) keep(to, reset);
}

void LinearLog::add_variances(const double* variances) {
  std::copy_n(variances, n_, add(Kind::variances, as_size(n_)));
}

ConstMatrixView LinearLog::noise(std::size_t event) const {
  const int size = events_[event].kind == Kind::update ? events_[event].rows : n_;
  return {numbers_.data() + events_[event].at, size, size, size};
}

int LinearLog::count_rows() const {
  int rows = 0;
  for (const Event& event : events_) rows += event.rows;
  return rows;
}

MatrixXd LinearLog::noise(std::size_t event, std::span<const double> c) const {
  MatrixXd A = noise(event).as();
  for (std::size_t p = 0; p < terms_.size(); ++p) {
    const SparseTerm& term = terms_[p][event];
    for (std::size_t k = 0; k < term.at.size(); ++k) {
      const auto i = term.at[k] % A.rows(), j = term.at[k] / A.rows();
      A(i, j) += c[p] * term.value[k];
      if (i != j) A(j, i) = A(i, j);
    }
  }
  return A;
}

bool LinearLog::update(std::size_t index, std::span<const double> c, Forward& state) const {
  const Event& event = events_[index];
  const int m = event.rows;
  const double* from = numbers_.data() + event.at + m * m;
  const auto H = Eigen::Map<const MatrixXd>(from, m, n_);
  const auto residual = Eigen::Map<const VectorXd>(from + m * n_, m);
  const auto fed_back = Eigen::Map<const VectorXd>(from + m * n_ + m, n_);
  Innovation it;
  it.R = noise(index, c);
  const MatrixXd PHt = state.P * H.transpose();
  it.S = H * PHt + it.R;
  it.S = 0.5 * (it.S + it.S.transpose()).eval();
  const algebra::Cholesky factor(it.S);
  if (!factor.is_positive()) return false;
  it.r = residual - H * state.d;
  const double nis = factor.solve_L_vector(it.r).squaredNorm();
  const double log_det = factor.log_determinant();
  state.likelihood -= 0.5 * (nis + log_det + m * std::log(2 * std::numbers::pi));
  it.K = factor.solve(PHt.transpose()).transpose();
  for (std::size_t i = 0; i < considered_.size(); ++i)
    if (considered_[i]) it.K.row(static_cast<Eigen::Index>(i)).setZero();
  const MatrixXd U = 0.5 * it.K * it.S - PHt;
  state.P += it.K * U.transpose() + U * it.K.transpose();
  state.d += it.K * it.r - fed_back;
  if (event.has_reset) {
    const auto T = Eigen::Map<const MatrixXd>(from + m * n_ + m + n_, n_, n_);
    state.d = (T * state.d).eval();
    state.P = (T * state.P * T.transpose()).eval();
  }
  state.P = 0.5 * (state.P + state.P.transpose()).eval();
  if (state.innovations) state.innovations->push_back(std::move(it));
  return true;
}

void LinearLog::step(std::size_t event, std::span<const double> c, Forward& state) const {
  const auto Phi = Eigen::Map<const MatrixXd>(numbers_.data() + events_[event].at + n_ * n_, n_, n_);
  state.d = (Phi * state.d).eval();
  state.P = (Phi * state.P * Phi.transpose()).eval() + noise(event, c);
  state.P = 0.5 * (state.P + state.P.transpose()).eval();
}

double LinearLog::likelihood(std::span<const double> c, double* gradient) const {
  std::vector<Innovation> innovations;
  Forward state{MatrixXd::Zero(n_, n_), VectorXd::Zero(n_), 0, gradient ? &innovations : nullptr};
  for (std::size_t e = 0; e < events_.size(); ++e) {
    const double* from = numbers_.data() + events_[e].at;
    switch (events_[e].kind) {
      case Kind::start:
        state.P = noise(e, c);
        state.d.setZero();
        break;
      case Kind::step: step(e, c, state); break;
      case Kind::update:
        if (!update(e, c, state)) return -std::numeric_limits<double>::infinity();
        break;
      case Kind::variances: state.P.diagonal() += Eigen::Map<const VectorXd>(from, n_); break;
    }
  }
  if (gradient) sweep(innovations, gradient);
  return std::isfinite(state.likelihood) ? state.likelihood : -std::numeric_limits<double>::infinity();
}

/// ½ ⟨∂A/∂c_i, v vᵀ − A⟩ of what the event has.
void LinearLog::add_slope(std::size_t event, const VectorXd& v, const MatrixXd& A, double* gradient) const {
  const auto size = noise(event).rows;
  for (std::size_t p = 0; p < terms_.size(); ++p) {
    const SparseTerm& term = terms_[p][event];
    for (std::size_t k = 0; k < term.at.size(); ++k) {
      const auto i = term.at[k] % size, j = term.at[k] / size;
      gradient[p] += (i == j ? 0.5 : 1.0) * term.value[k] * (v[i] * v[j] - A(i, j));
    }
  }
}

void LinearLog::sweep(const std::vector<Innovation>& innovations, double* gradient) const {
  std::fill_n(gradient, terms_.size(), 0.0);
  int most = 1;
  for (const Event& event : events_) most = std::max(most, event.rows);
  const smooth::TransitionPattern dense(n_);
  smooth::CoStates co_states(dense, {}, most);
  auto innovation = innovations.rbegin();
  for (std::size_t e = events_.size(); e-- > 0;) {
    const Event& event = events_[e];
    const double* from = numbers_.data() + event.at;
    switch (event.kind) {
      case Kind::start:
        add_slope(e, co_states.lambda(), co_states.Lambda(), gradient);
        co_states.clear();
        break;
      case Kind::step:
        add_slope(e, co_states.lambda(), co_states.Lambda(), gradient);
        co_states.step(from + n_ * n_, {});
        break;
      case Kind::update: {
        const int m = event.rows;
        smooth::UpdateTerms terms;
        terms.H = {from + m * m, m, n_, m};
        terms.K = view(innovation->K);
        terms.S = view(innovation->S);
        terms.R = view(innovation->R);
        terms.residual = innovation->r.data();
        if (event.has_reset) terms.reset = {from + m * m + m * n_ + m + n_, n_, n_, n_};
        co_states.update(terms);
        add_slope(e, co_states.s(m), co_states.D(m), gradient);
        ++innovation;
        break;
      }
      case Kind::variances: break;
    }
  }
}

// ---- sensitivities

/// What belongs to a parameter stands beside that of the one before.
struct LinearLog::Sensitivity {
  Sensitivity(int n, int parameters, int draws)
      : count(parameters),
        P(MatrixXd::Zero(n, n * parameters)),
        d(MatrixXd::Zero(n, parameters)),
        drawn(MatrixXd::Zero(n, draws * parameters)),
        gradient(VectorXd::Zero(parameters)),
        information(MatrixXd::Zero(parameters, parameters)) {}

  int count;
  MatrixXd P;      // ∂P/∂c_i
  MatrixXd d;      // ∂d/∂c_i
  MatrixXd drawn;  // the same of drawn innovations, a column each
  VectorXd gradient;
  MatrixXd information;
  std::mt19937_64 random{};
  std::normal_distribution<double> normal{};
  MatrixXd scratch{};

  auto P_of(int i) { return P.middleCols(i * P.rows(), P.rows()); }
  auto drawn_of(int i) { return drawn.middleCols(i * (drawn.cols() / count), drawn.cols() / count); }
  void transform(const Eigen::Ref<const MatrixXd>& A) {
    scratch.noalias() = A * P;
    for (int i = 0; i < count; ++i) P_of(i) = scratch.middleCols(i * P.rows(), P.rows()).transpose();
    scratch.noalias() = A * P;
    P.swap(scratch);
    d = A * d;
    drawn = A * drawn;
  }
  void clear() {
    P.setZero();
    d.setZero();
    drawn.setZero();
  }
};

MatrixXd LinearLog::term(std::size_t event, std::size_t parameter) const {
  const auto size = noise(event).rows;
  MatrixXd A = MatrixXd::Zero(size, size);
  const SparseTerm& term = terms_[parameter][event];
  for (std::size_t k = 0; k < term.at.size(); ++k) {
    const auto i = term.at[k] % size, j = term.at[k] / size;
    A(i, j) = A(j, i) = term.value[k];
  }
  return A;
}

void LinearLog::update(std::size_t event, const Innovation& it, Sensitivity& all) const {
  const int m = events_[event].rows, count = all.count;
  const double* from = numbers_.data() + events_[event].at + m * m;
  const auto H = Eigen::Map<const MatrixXd>(from, m, n_);
  const algebra::Cholesky S(it.S);
  const VectorXd y = S.solve_vector(it.r);
  const MatrixXd HP = H * all.P, Hd = H * all.d, H_drawn = H * all.drawn;
  const auto draws = all.drawn.cols() / std::max(1, count);
  std::vector<MatrixXd> dR, SdS, dK, seen;  // seen: S^-½ H ∂d_i of drawn innovations
  for (int i = 0; i < count; ++i) {
    const auto of_i = HP.middleCols(i * n_, n_);
    dR.push_back(term(event, as_size(i)));
    const MatrixXd dS = of_i * H.transpose() + dR.back();
    SdS.push_back(S.solve(dS));
    dK.push_back(S.solve(of_i - dS * it.K.transpose()).transpose());
    seen.push_back(S.solve_L(H_drawn.middleCols(i * draws, draws)));
    all.gradient[i] += 0.5 * (y.dot(dS * y) - SdS.back().trace()) + Hd.col(i).dot(y);
    for (int j = 0; j <= i; ++j)
      all.information(i, j) += 0.5 * SdS[as_size(i)].cwiseProduct(SdS[as_size(j)].transpose()).sum() +
                               seen[as_size(i)].cwiseProduct(seen[as_size(j)]).sum() / static_cast<double>(draws);
  }
  MatrixXd innovations(m, draws);
  for (double& value : innovations.reshaped()) value = all.normal(all.random);
  innovations = S.times_L(innovations);
  all.P.noalias() -= it.K * HP;
  all.d.noalias() -= it.K * Hd;
  all.drawn.noalias() -= it.K * H_drawn;
  for (int i = 0; i < count; ++i) {
    const MatrixXd PHt = all.P_of(i) * H.transpose() - it.K * dR[as_size(i)];
    all.P_of(i).noalias() -= PHt * it.K.transpose();
    all.d.col(i) += dK[as_size(i)] * it.r;
    all.drawn_of(i).noalias() += dK[as_size(i)] * innovations;
  }
  if (events_[event].has_reset) all.transform(Eigen::Map<const MatrixXd>(from + m * n_ + m + n_, n_, n_));
}

double LinearLog::information(std::span<const double> c, VectorXd& gradient, MatrixXd& information, int draws) const {
  const int count = parameters();
  const MatrixXd zero = MatrixXd::Zero(n_, n_);
  Sensitivity all(n_, count, draws);
  std::vector<Innovation> innovations;
  Forward state{zero, VectorXd::Zero(n_), 0, &innovations};
  for (std::size_t e = 0; e < events_.size(); ++e) {
    const double* from = numbers_.data() + events_[e].at;
    switch (events_[e].kind) {
      case Kind::start:
        state.P = noise(e, c);
        state.d.setZero();
        all.clear();
        for (int i = 0; i < count; ++i) all.P_of(i) = term(e, as_size(i));
        break;
      case Kind::step:
        step(e, c, state);
        all.transform(Eigen::Map<const MatrixXd>(from + n_ * n_, n_, n_));
        for (int i = 0; i < count; ++i) all.P_of(i) += term(e, as_size(i));
        break;
      case Kind::update: {
        innovations.clear();
        if (!update(e, c, state)) return -std::numeric_limits<double>::infinity();
        update(e, innovations.back(), all);
        break;
      }
      case Kind::variances: state.P.diagonal() += Eigen::Map<const VectorXd>(from, n_); break;
    }
  }
  gradient = all.gradient;
  information = all.information.selfadjointView<Eigen::Lower>();
  return state.likelihood;
}

}  // namespace binnacle::tune
