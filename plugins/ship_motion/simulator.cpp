// SPDX-License-Identifier: Apache-2.0
#include "simulator.hpp"

#include <new>
#include <type_traits>

#include <Eigen/Cholesky>
#include <unsupported/Eigen/MatrixFunctions>

#include "random/normal.hpp"

namespace binnacle::ship_motion {

namespace {

FieldSpec level(const char* name, const char* unit, const char* text) {
  FieldSpec field;
  field.name = name;
  field.unit = unit;
  field.text = text;
  return field;
}

}  // namespace

struct Simulator::Memory {
  random::Philox engine;
  double x[4];
  Time t;             // of x
  bool is_truth_out;  // x has been told, the reading has not
};

ComponentSpec Simulator::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "simulator";
  spec.summary =
      "One angle of a ship in waves by its shaping filter of order 2, read by a gyro that drifts, and truth.";
  spec.source =
      "paper 004, section 3; Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23(3), 1978";
  spec.parameters = {
      number("omega", "rad/s").above(0).required().about("natural frequency of the motion"),
      number("zeta", "1").above(0).required().about("its damping ratio"),
      number("sigma", "rad").at_least(0).required().about("standard deviation of the angle"),
      number("noise", "rad").at_least(0).required().about("standard deviation of the reading's white noise"),
      number("drift", "rad/s").at_least(0).defaults("0").about("standard deviation of the gyro's drift"),
      number("drift_tau", "s").above(0).defaults("3600").about("correlation time of the drift"),
      parameter::time("interval").above(0).defaults("\"1 s\"").about("between samples, the first at time zero"),
      parameter::time("duration").at_least(0).defaults("\"60 s\"").about("last sample"),
  };
  spec.example =
      R"json({"omega": 1.98, "zeta": 0.2235, "sigma": "0.825 deg", "noise": "0.5 deg", "drift": "60 deg/h"})json";
  return spec;
}

Simulator::Simulator(const Binding& binding)
    : interval_(binding.parameters().time("interval")),
      duration_(binding.parameters().time("duration")),
      noise_(binding.parameters().number("noise")) {
  const Parameters& parameters = binding.parameters();
  const double w = parameters.number("omega"), z = parameters.number("zeta"), sigma = parameters.number("sigma");
  const double drift = parameters.number("drift"), tau = parameters.number("drift_tau");
  first_sigma_ << sigma, w * sigma, 0, drift;
  Eigen::Matrix4d F = Eigen::Matrix4d::Zero();
  F(0, 1) = 1;
  F(1, 0) = -w * w;
  F(1, 1) = -2 * z * w;
  F(2, 3) = 1;
  F(3, 3) = -1 / tau;
  Eigen::Matrix<double, 8, 8> A = Eigen::Matrix<double, 8, 8>::Zero();
  A.topLeftCorner<4, 4>() = -F;
  A(1, 5) = 4 * z * w * w * w * sigma * sigma;
  A(3, 7) = 2 * drift * drift / tau;
  A.bottomRightCorner<4, 4>() = F.transpose();
  const Eigen::Matrix<double, 8, 8> E = (A * seconds(interval_)).exp();
  Phi_ = E.bottomRightCorner<4, 4>().transpose();
  const Eigen::Matrix4d Q = Phi_ * E.topRightCorner<4, 4>();
  // Motion and drift are independent, and of very different size.
  root_Q_.setZero();
  for (const int k : {0, 2}) {
    const Eigen::Matrix2d block = 0.5 * (Q.block<2, 2>(k, k) + Q.block<2, 2>(k, k).transpose());
    if (block(1, 1) > 0) root_Q_.block<2, 2>(k, k) = block.llt().matrixL();
  }
  channels_.resize(2);
  channels_[truth].name = "truth";
  channels_[truth].fields = {level("angle", "rad", "of the ship"), level("rate", "rad/s", "of the angle"),
                             level("error", "rad", "what the drift has added to the reading"),
                             level("drift", "rad/s", "of the gyro")};
  channels_[gyro].name = "gyro";
  channels_[gyro].fields = {level("angle", "rad", "as read: angle, error and white noise")};
}

std::size_t Simulator::memory_bytes() const noexcept { return sizeof(Memory); }

void Simulator::start(std::uint64_t seed, std::byte* bytes) const {
  static_assert(std::is_trivially_copyable_v<Memory>);
  Memory& memory = *new (bytes) Memory{random::stream(seed, "ship"), {}, 0, false};
  for (int i = 0; i < 4; ++i) memory.x[i] = first_sigma_[i] * random::normal(memory.engine);
}

SourceStatus Simulator::next(std::byte* bytes, SampleSlot* slots, int& channel) const {
  Memory& memory = *std::launder(reinterpret_cast<Memory*>(bytes));
  if (memory.t > duration_) return SourceStatus::end;
  Eigen::Map<Eigen::Vector4d, Eigen::Unaligned> x(memory.x);
  channel = memory.is_truth_out ? gyro : truth;
  SampleSlot& slot = slots[channel];
  slot.t = memory.t;
  memory.is_truth_out = !memory.is_truth_out;
  if (channel == truth) {
    for (int i = 0; i < 4; ++i) slot.fields[i] = x[i];
    return SourceStatus::sample;
  }
  slot.fields[0] = x[0] + x[2] + noise_ * random::normal(memory.engine);
  Eigen::Vector4d w;
  for (int i = 0; i < 4; ++i) w[i] = random::normal(memory.engine);
  x = (Phi_ * x + root_Q_ * w).eval();
  memory.t += interval_;
  return SourceStatus::sample;
}

}  // namespace binnacle::ship_motion
