// SPDX-License-Identifier: Apache-2.0
// How a direction that is fixed in space moves in the axes of a body that turns.
#pragma once

#include <binnacle/plugin.hpp>

#include <cmath>

#include "s2.hpp"

/// ẋ = −(ω − b) × x, with the gyro's rates ω and a bias b of them, that may be left out. Over an interval dt, with
/// φ = −(ω − b) dt and Rodrigues' rotation R = exp([φ]×):
///
///     x⁺ = R x, and so do the axes, B⁺ = R B: Φ_xx = B⁺ᵀ R B = I
///     Φ_xb = −B⁺ᵀ [x⁺]× J(φ) dt             J the left Jacobian of SO(3): δφ turns what is rotated by J(φ) δφ
///     Qd = q² dt I, q the gyro's white noise, which is the same in all directions
///
/// J. Solà, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation in robotics", 2018, (145).
class Turning final : public binnacle::ProcessModel {
 public:
  static binnacle::ComponentSpec spec() {
    using namespace binnacle;
    ComponentSpec spec;
    spec.type = "turning";
    spec.summary = "A direction fixed in space, in the axes of a body with gyros: the vertical, a star.";
    spec.source = "Sola, Deray, Atchuthan, A micro Lie theory for state estimation in robotics, 2018, (145)";
    spec.parameters = {parameter::number("gyro_noise", "rad/s/sqrt(Hz)")
                           .at_least(0)
                           .required()
                           .about("q, root of the power spectral density of each gyro's white noise")};
    spec.ports = {advances("direction", "direction", "of what is fixed in space, in axes of the body"),
                  reads("gyro_bias", "vector:3:rad/s").optional().about("what the gyros show too much")};
    spec.fields = {field::rate("wx", "rad/s").about("angular rate of the body about its x axis"),
                   field::rate("wy", "rad/s").about("about y"), field::rate("wz", "rad/s").about("about z")};
    spec.example = R"json({"input": "gyro", "blocks": {"direction": "down", "gyro_bias": "bias"},
      "gyro_noise": "0.1 deg/s/sqrt(Hz)"})json";
    spec.surroundings = R"json({"blocks": {
      "down": {"type": "direction", "init": {"x": 0, "y": 0.6, "z": 0.8}, "sigma": "2 deg"},
      "bias": {"type": "vector", "size": 3, "unit": "rad/s", "sigma": "0.2 deg/s"}}})json";
    return spec;
  }

  explicit Turning(const binnacle::Binding& b)
      : direction_(b.port("direction")),
        bias_(b.port("gyro_bias")),
        rates_(b.fields("wx", "wy", "wz")),
        density_(std::pow(b.parameters().number("gyro_noise"), 2)) {
    phi_xb_ = declaration_.couples(direction_, bias_);  // of an open port: nothing
    q_xx_ = declaration_.adds_noise(direction_, direction_);
  }

  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    s2::Vector3 bias = s2::Vector3::Zero();
    if (bias_.is_bound()) bias = in.x[bias_].as<3>();

    // R of all samples together, and E = ∂(what turns x⁺)/∂b.
    Matrix3 R = Matrix3::Identity(), E = Matrix3::Zero();
    for (const auto& sample : in.step.samples) {
      const s2::Vector3 turn = (bias - sample[rates_]) * sample.dt;
      if (!(turn.norm() < most_turn)) return binnacle::Result::failed("more than a thousand turns in a sample");
      const Matrix3 more = rotation(turn);
      E = more * E + left_jacobian(turn) * sample.dt;
      R = more * R;
    }
    const s2::Frame after = s2::orthonormal(R * binnacle::matrix_at<3, 3>(in.x[direction_].data()));
    binnacle::matrix_at<3, 3>(out.x[direction_].data()) = after;
    if (auto Phi = out.phi[phi_xb_]) Phi.as<2, 3>() = -s2::axes(after).transpose() * cross(s2::direction(after)) * E;
    if (auto Q = out.Qd[q_xx_]) Q.as<2, 2>() = density_ * in.step.dt * Eigen::Matrix2d::Identity();
    return binnacle::Result::ok();
  }

 private:
  using Matrix3 = Eigen::Matrix3d;
  static constexpr double most_turn = 6e3;  // rad

  static Matrix3 cross(const s2::Vector3& v) {
    Matrix3 m;
    m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
    return m;
  }
  static Matrix3 rotation(const s2::Vector3& phi) {
    const Matrix3 X = cross(phi);
    return Matrix3::Identity() + s2::sinc(phi.norm()) * X + s2::versine(phi.norm()) * X * X;
  }
  static Matrix3 left_jacobian(const s2::Vector3& phi) {
    const Matrix3 X = cross(phi);
    return Matrix3::Identity() + s2::versine(phi.norm()) * X + s2::sinc_fall(phi.norm()) * X * X;
  }

  binnacle::Port direction_, bias_;
  binnacle::Fields<3> rates_;
  binnacle::PhiBlock phi_xb_;
  binnacle::QBlock q_xx_;
  double density_;  // rad²/s
};
