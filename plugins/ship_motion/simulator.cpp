// SPDX-License-Identifier: Apache-2.0
#include "simulator.hpp"

#include <new>
#include <type_traits>

#include <Eigen/Cholesky>
#include <unsupported/Eigen/MatrixFunctions>

#include "motion_parameters.hpp"
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

/// A with A Aᵀ = P; P may be singular.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& P) {
  const Eigen::MatrixXd symmetric = 0.5 * (P + P.transpose());
  const Eigen::LLT<Eigen::MatrixXd> positive(symmetric);
  if (positive.info() == Eigen::Success) return positive.matrixL();
  const Eigen::LDLT<Eigen::MatrixXd> semidefinite(symmetric);
  Eigen::MatrixXd L = semidefinite.matrixL();
  L *= semidefinite.vectorD().cwiseMax(0).cwiseSqrt().asDiagonal();
  return semidefinite.transpositionsP().transpose() * L * semidefinite.transpositionsP();
}

}  // namespace

struct Simulator::Memory {
  random::Philox engine;
  double x[max_states];
  std::int64_t sample;  // whose state x is
  std::int64_t next;    // channel
};

ComponentSpec Simulator::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "simulator";
  spec.summary =
      "One angle of a ship in waves, by its shaping filter or as recorded, read by a gyro that drifts, and truth.";
  spec.source =
      "paper 004, section 3; Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23(3), 1978";
  spec.parameters = motion_parameters("rad");
  for (auto& parameter : std::vector<ParameterSpec>{
           object("record", RecordPlace::parameters()).about("instead of a motion: one as recorded, less its mean"),
           number("noise", "rad").at_least(0).required().about("standard deviation of the reading's white noise"),
           number("drift", "rad/s").at_least(0).defaults("0").about("standard deviation of the gyro's drift"),
           number("drift_tau", "s").above(0).defaults("3600").about("correlation time of the drift"),
           parameter::time("interval")
               .above(0)
               .about("between samples, the first at time zero; default 1 s. Not of a record"),
           parameter::time("duration").at_least(0).about("last sample; default 60 s. Not of a record"),
       })
    spec.parameters.push_back(std::move(parameter));
  spec.example =
      R"json({"omega": [1.98], "zeta": [0.2235], "sigma": "0.825 deg", "noise": "0.5 deg", "drift": "60 deg/h"})json";
  return spec;
}

Simulator::Simulator(const Binding& binding) : noise_(binding.parameters().number("noise")) {
  const Parameters& parameters = binding.parameters();
  Eigen::MatrixXd motion, first;
  double motion_density = 0;
  if (parameters.has("record")) {
    for (const char* name : {"omega", "zeta", "sigma", "fit", "interval", "duration"})
      if (parameters.has(name))
        throw ComponentError(std::string("a recorded motion has no '") + name + "'", std::string("/") + name);
    place_.emplace(parameters, "rad", "/record");
  } else {
    const ShapingFilter filter = read_motion(binding, "rad");
    order_ = static_cast<int>(filter.order());
    motion = filter.dynamics();
    first = filter.steady_covariance();
    motion_density = filter.noise_density();
    interval_ = parameters.has("interval") ? parameters.time("interval") : nanoseconds_per_second;
    duration_ = parameters.has("duration") ? parameters.time("duration") : 60 * nanoseconds_per_second;
  }
  const int error = order_, drift = order_ + 1, n = order_ + 2;
  const double drift_sigma = parameters.number("drift"), tau = parameters.number("drift_tau");
  F_ = density_ = root_P_ = Square::Zero(n, n);
  if (order_ > 0) {
    F_.topLeftCorner(order_, order_) = motion;
    density_(order_ - 1, order_ - 1) = motion_density;
    root_P_.topLeftCorner(order_, order_) = root_of(first);
  }
  F_(error, drift) = 1;
  F_(drift, drift) = -1 / tau;
  density_(drift, drift) = 2 * drift_sigma * drift_sigma / tau;
  root_P_(drift, drift) = drift_sigma;
  if (!is_recorded()) discretize(seconds(interval_));
  declare_channels();
}

void Simulator::declare_channels() {
  channels_.resize(2);
  channels_[truth].name = "truth";
  channels_[truth].fields = {level("angle", "rad", "of the ship")};
  if (!is_recorded()) channels_[truth].fields.push_back(level("rate", "rad/s", "of the angle"));
  channels_[truth].fields.push_back(level("error", "rad", "what the drift has added to the reading"));
  channels_[truth].fields.push_back(level("drift", "rad/s", "of the gyro"));
  channels_[gyro].name = "gyro";
  channels_[gyro].fields = {level("angle", "rad", "as read: angle, error and white noise")};
}

void Simulator::discretize(double interval) {
  const Eigen::Index n = F_.rows();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  A.topLeftCorner(n, n) = -F_;
  A.topRightCorner(n, n) = density_;
  A.bottomRightCorner(n, n) = F_.transpose();
  const Eigen::MatrixXd E = (A * interval).exp();
  Phi_ = E.bottomRightCorner(n, n).transpose();
  const Eigen::MatrixXd Q = Phi_ * E.topRightCorner(n, n);
  // Motion and drift are independent, and of very different size.
  root_Q_ = Square::Zero(n, n);
  if (order_ > 0) root_Q_.topLeftCorner(order_, order_) = root_of(Q.topLeftCorner(order_, order_));
  root_Q_.bottomRightCorner(2, 2) = root_of(Q.bottomRightCorner(2, 2));
}

void Simulator::open(Reporter& /*reporter*/) {
  if (!is_recorded()) return;
  record_ = place_->read();
  discretize(record_.interval);
}

std::size_t Simulator::memory_bytes() const noexcept { return sizeof(Memory); }

void Simulator::start(std::uint64_t seed, std::byte* bytes) const {
  static_assert(std::is_trivially_copyable_v<Memory>);
  Memory& memory = *new (bytes) Memory{random::stream(seed, "ship"), {}, 0, truth};
  States w(F_.rows());
  for (Eigen::Index i = 0; i < w.size(); ++i) w[i] = random::normal(memory.engine);
  Eigen::Map<States, Eigen::Unaligned>(memory.x, w.size()) = root_P_ * w;
}

bool Simulator::is_over(const Memory& memory) const {
  if (memory.sample < 0) return true;
  return is_recorded() ? memory.sample >= static_cast<std::int64_t>(record_.times.size())
                       : memory.sample > duration_ / interval_;
}

SourceStatus Simulator::next(std::byte* bytes, SampleSlot* slots, int& channel) const {
  Memory& memory = *std::launder(reinterpret_cast<Memory*>(bytes));
  if (is_over(memory)) return SourceStatus::end;
  Eigen::Map<States, Eigen::Unaligned> x(memory.x, F_.rows());
  const auto row = static_cast<std::size_t>(memory.sample);
  const double angle = is_recorded() ? record_.values[memory.sample] : x[0];
  channel = memory.next == truth ? truth : gyro;
  SampleSlot& slot = slots[channel];
  slot.t = is_recorded() ? record_.times[row] : memory.sample * interval_;
  memory.next = channel == truth ? gyro : truth;
  if (channel == truth) {
    int field = 0;
    slot.fields[field++] = angle;
    if (!is_recorded()) slot.fields[field++] = x[1];
    slot.fields[field++] = x[order_];
    slot.fields[field++] = x[order_ + 1];
    return SourceStatus::sample;
  }
  slot.fields[0] = angle + x[order_] + noise_ * random::normal(memory.engine);
  States w(x.size());
  for (Eigen::Index i = 0; i < w.size(); ++i) w[i] = random::normal(memory.engine);
  x = (Phi_ * x + root_Q_ * w).eval();
  ++memory.sample;
  return SourceStatus::sample;
}

}  // namespace binnacle::ship_motion
