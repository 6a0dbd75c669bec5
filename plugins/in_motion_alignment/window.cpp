// SPDX-License-Identifier: Apache-2.0
#include "window.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "algebra/decompositions.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::in_motion_alignment {

namespace sd = strapdown;
using Eigen::Map;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

constexpr double gravity = 9.80665;

using Unknowns = Eigen::Matrix<double, 9, 1>;  // φ, accelerometer bias, gyro bias
using Jacobian = Eigen::Matrix<double, 3, 9>;
using Normal = Eigen::Matrix<double, 9, 9>;

Vector3d vector(const double* values) { return Map<const Vector3d>(values); }
Matrix3d matrix(const double* values) { return Map<const Matrix3d>(values); }

}  // namespace

struct Biases {
  Vector3d accelerometer = Vector3d::Zero(), gyro = Vector3d::Zero();
};

/// The integrals from the first epoch on, less biases, and what small further biases change of them.
class Chain {
 public:
  explicit Chain(const Biases& biases) : biases_(biases) {}
  void add(const Integrals& next) {
    const Matrix3d M = matrix(next.axes), N = matrix(next.turned);
    const Vector3d a = R_ * (vector(next.force) - M * biases_.accelerometer + N * biases_.gyro);
    turned_ += R_ * N + sd::skew(a) * axes_;
    axes_ += R_ * M;
    force_ += a;
    const Matrix3d turn = sd::dcm_from_quaternion(sd::quaternion_exp(-M * biases_.gyro));
    R_ = R_ * turn * sd::dcm_from_quaternion(Map<const Vector4d>(next.q));
  }
  const Matrix3d& rotation() const { return R_; }  // C_b0b
  const Vector3d& force() const { return force_; }
  const Matrix3d& axes() const { return axes_; }
  const Matrix3d& turned() const { return turned_; }

 private:
  const Biases& biases_;
  Matrix3d R_ = Matrix3d::Identity();
  Vector3d force_ = Vector3d::Zero();
  Matrix3d axes_ = Matrix3d::Zero(), turned_ = Matrix3d::Zero();
};

namespace {

/// v − g t from the first epoch on.
Vector3d felt(const Epoch& first, const Epoch& epoch) {
  return vector(epoch.velocity) - vector(first.velocity) - Vector3d(0, 0, gravity * seconds(epoch.t - first.t));
}

}  // namespace

void Integrals::add(double dt, const Vector3d& rate, const Vector3d& specific_force) {
  Map<Vector4d> quaternion(q);
  const Matrix3d C = sd::dcm_from_quaternion(sd::quaternion_product(quaternion, sd::quaternion_exp(0.5 * dt * rate)));
  const Vector3d f = C * specific_force;
  Map<Matrix3d> M(axes), N(turned);
  N += dt * sd::skew(f) * (M + 0.5 * dt * C);
  M += dt * C;
  Map<Vector3d>(force) += dt * f;
  quaternion = sd::quaternion_normalised(sd::quaternion_product(quaternion, sd::quaternion_exp(dt * rate)));
}

void Window::add(const Epoch& epoch, Time length) {
  if (count_ > capacity) clear();  // of a forged snapshot
  if (count_ == capacity) {
    ++first_;
    --count_;
  }
  epochs_[(first_ + count_++) % capacity] = epoch;
  while (count_ > 1 && epoch.t - at(0).t > length) {
    ++first_;
    --count_;
  }
}

Window Window::newest(std::size_t count) const {
  Window window = *this;
  window.count_ = std::min<std::uint64_t>(count, count_);
  window.first_ += count_ - window.count_;
  return window;
}

template <class Use>
void Window::for_each(Chain& chain, Use&& use) const {
  for (std::size_t k = 0; k < count_; ++k) {
    if (k > 0) chain.add(at(k).since_last);
    use(at(k), felt(at(0), at(k)));
  }
}

/// C_nb0 by the singular values of Σ (v − g t) aᵀ, both less their means, so that the first velocity is one of many
/// (Markley, Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, 2014, 5.2).
Matrix3d Window::rotation() const {
  Matrix3d B = Matrix3d::Zero();
  Vector3d sum_felt = Vector3d::Zero(), sum_force = Vector3d::Zero();
  const Biases none;
  Chain chain(none);
  for_each(chain, [&](const Epoch&, const Vector3d& y) {
    B += y * chain.force().transpose();
    sum_felt += y;
    sum_force += chain.force();
  });
  B -= sum_felt * sum_force.transpose() / static_cast<double>(count_);
  return algebra::singular_values(B).nearest_rotation();
}

// With C_true = (I + [φ]×) C, f_true = f − b_a, ω_true = ω − b_g, T = ∫ C_b0b dt and G = ∫ [C_b0b f]× T dt,
//     v − g t − C a = c − [C a]× φ − C T b_a + C G b_g ,
// where c goes with the means. At the last epoch φ is less by C T b_g.
Fit Window::fit(const Priors& priors) const {
  constexpr std::size_t least = 8;
  return count_ < least ? Fit{} : fit_from(rotation(), priors, {});
}

Fit Window::fit(const Priors& priors, const Course& course) const {
  constexpr std::size_t least = 3;
  if (count_ < least || vector(at(count_ - 1).velocity).norm() < course.min_speed) return {};
  return fit_from(rotation_by_course(), priors, course);
}

/// C_nb0 from two directions that both frames know (Black, 1964): what is felt, and the course at the end.
Matrix3d Window::rotation_by_course() const {
  const Biases none;
  Chain chain(none);
  Vector3d y = Vector3d::Zero();
  for_each(chain, [&](const Epoch&, const Vector3d& felt) { y = felt; });
  const auto triad = [](const Vector3d& down, const Vector3d& forward) {
    Matrix3d axes;
    axes.col(0) = down.normalized();
    axes.col(1) = down.cross(forward).normalized();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    return axes;
  };
  const Vector3d velocity = vector(at(count_ - 1).velocity);
  return triad(-y, velocity) * triad(-chain.force(), chain.rotation().col(0)).transpose();
}

namespace {

/// Normal equations of residuals r = H u + c, in which c is the same for all and goes with their means.
struct Equations {
  Normal normal = Normal::Zero();
  Unknowns right = Unknowns::Zero();
  Jacobian sum_H = Jacobian::Zero();
  Vector3d sum_r = Vector3d::Zero();
  double weights = 0, squares = 0;

  template <class H, class R>
  void add(const H& jacobian, const R& r, double weight) {
    normal += weight * jacobian.transpose() * jacobian;
    right += weight * jacobian.transpose() * r;
    squares += weight * r.squaredNorm();
  }
  void add_with_constant(const Jacobian& H, const Vector3d& r, double weight) {
    add(H, r, weight);
    sum_H += weight * H;
    sum_r += weight * r;
    weights += weight;
  }
  void take_out_constant() {
    normal -= sum_H.transpose() * sum_H / weights;
    right -= sum_H.transpose() * sum_r / weights;
    squares -= sum_r.squaredNorm() / weights;
  }
  /// What is known beforehand: zero, with these weights, where `found` is assumed already.
  void add_prior(const Unknowns& prior_weights, const Unknowns& found) {
    normal.diagonal() += prior_weights;
    right -= prior_weights.cwiseProduct(found);
    squares += prior_weights.dot(found.cwiseAbs2());
  }
};

/// φ at the last epoch, and what it is made of.
Jacobian at_the_end(const Matrix3d& C, const Chain& chain) {
  Jacobian now;
  now << Matrix3d::Identity(), Matrix3d::Zero(), -C * chain.axes();
  return now;
}

Unknowns weights_of(const Priors& priors) {
  Unknowns weights = Unknowns::Zero();
  weights.segment<3>(3).setConstant(1 / (priors.accelerometer_bias * priors.accelerometer_bias));
  weights.tail<3>().setConstant(1 / (priors.gyro_bias * priors.gyro_bias));
  return weights;
}

// In the body axes of the last epoch, with v the velocity there:
//     0 − (C_bn v)_y,z = (C_bn [v]×)_y,z φ_now .
void add_course(const Course& course, const Epoch& last, const Matrix3d& C, const Chain& chain, Equations& equations) {
  const Vector3d v = vector(last.velocity);
  const Matrix3d C_bn = (C * chain.rotation()).transpose();
  const Eigen::Matrix<double, 2, 9> H = (C_bn * sd::skew(v) * at_the_end(C, chain)).bottomRows<2>();
  const Eigen::Vector2d r = -(C_bn * v).tail<2>();
  equations.add(H, r, 1 / (course.sd * course.sd * v.squaredNorm() + last.variance));
}

}  // namespace

Fit Window::fit_from(Matrix3d C, const Priors& priors, const Course& course) const {
  Fit fit;
  Biases biases;
  const bool has_course = course.sd > 0;
  for (int iteration = 0; iteration < 5; ++iteration) {
    Equations equations;
    Chain chain(biases);
    for_each(chain, [&](const Epoch& epoch, const Vector3d& y) {
      const Vector3d force = C * chain.force();
      Jacobian H;
      H << -sd::skew(force), -C * chain.axes(), C * chain.turned();
      equations.add_with_constant(H, y - force, 1 / epoch.variance);
    });
    equations.take_out_constant();
    Unknowns found;
    found << Vector3d::Zero(), biases.accelerometer, biases.gyro;
    equations.add_prior(weights_of(priors), found);
    if (has_course) add_course(course, at(count_ - 1), C, chain, equations);
    const algebra::Cholesky factor(equations.normal);
    if (!factor.is_positive()) return fit;
    const Unknowns step = factor.solve_vector(equations.right);
    const Normal P = factor.solve(Normal::Identity());
    C = sd::dcm_from_quaternion(sd::quaternion_exp(step.head<3>())) * C;
    biases.accelerometer += step.segment<3>(3);
    biases.gyro += step.tail<3>();

    // Residuals and priors: 3 n + 6 numbers, less c and the unknowns; two of the course.
    const double freedom = 3.0 * static_cast<double>(count_) - 6.0 + (has_course ? 2 : 0);
    fit.misfit = std::sqrt(std::max(0.0, equations.squares - equations.right.dot(step)) / freedom);
    const double excess = std::max(1.0, fit.misfit * fit.misfit);  // what the model leaves out
    const Jacobian now = at_the_end(C, chain);
    fit.P = excess * now * P * now.transpose();
    fit.q_nb = sd::quaternion_from_dcm(C * chain.rotation());
    fit.P_gyro_bias = excess * P.bottomRightCorner<3, 3>();
  }
  fit.gyro_bias = biases.gyro;
  fit.is_found = true;
  return fit;
}

}  // namespace binnacle::in_motion_alignment
