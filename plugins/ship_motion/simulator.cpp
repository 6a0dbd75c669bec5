// SPDX-License-Identifier: Apache-2.0
#include "simulator.hpp"

#include "algebra/decompositions.hpp"
#include "motion_parameters.hpp"
#include "random/normal.hpp"

namespace binnacle::ship_motion {

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
      "One angle of a ship in waves, from a shaping filter or a record: measurements of a drifting gyro, and truth.";
  spec.source =
      "paper 004, section 3; Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23(3), 1978";
  spec.parameters = motion_parameters("rad");
  for (auto& parameter : std::vector<ParameterSpec>{
           object("record", RecordPlace::parameters())
               .about("recorded motion with its mean removed, instead of a simulated motion"),
           number("noise", "rad").at_least(0).required().about("standard deviation of the measurement's white noise"),
           number("drift", "rad/s").at_least(0).defaults("0").about("standard deviation of the gyro's drift"),
           number("drift_tau", "s").above(0).defaults("3600").about("correlation time of the drift"),
           parameter::time("interval")
               .above(0)
               .about("time between samples, the first at time zero; default: 1 s; not for a record"),
           parameter::time("duration").at_least(0).about("time of the last sample; default: 60 s; not for a record"),
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
    root_P_.topLeftCorner(order_, order_) = algebra::root(first);
  }
  F_(error, drift) = 1;
  F_(drift, drift) = -1 / tau;
  density_(drift, drift) = 2 * drift_sigma * drift_sigma / tau;
  root_P_(drift, drift) = drift_sigma;
  if (!is_recorded()) discretize(seconds(interval_));
  declare_channels();
}

void Simulator::declare_channels() {
  using field::level;
  ChannelDeclaration of_truth("truth"), of_gyro("gyro");
  angle_ = of_truth.carries(level("angle", "rad").about("speed of the ship"));
  if (!is_recorded()) rate_ = of_truth.carries(level("rate", "rad/s").about("of the angle"));
  error_ = of_truth.carries(level("error", "rad").about("what the drift has added to the reading"));
  drift_ = of_truth.carries(level("drift", "rad/s").about("of the gyro"));
  reading_ = of_gyro.carries(level("angle", "rad").about("as read: angle, error and white noise"));
  truth_channel_ = declaration_.emits(std::move(of_truth));
  gyro_channel_ = declaration_.emits(std::move(of_gyro));
  memory_ = declaration_.keeps<Memory>();
}

void Simulator::discretize(double interval) {
  const Eigen::Index n = F_.rows();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  A.topLeftCorner(n, n) = -F_;
  A.topRightCorner(n, n) = density_;
  A.bottomRightCorner(n, n) = F_.transpose();
  const Eigen::MatrixXd E = algebra::exponential(A * interval);
  Phi_ = E.bottomRightCorner(n, n).transpose();
  const Eigen::MatrixXd Q = Phi_ * E.topRightCorner(n, n);
  // Motion and drift are independent, and of very different size.
  root_Q_ = Square::Zero(n, n);
  if (order_ > 0) root_Q_.topLeftCorner(order_, order_) = algebra::root(Q.topLeftCorner(order_, order_));
  root_Q_.bottomRightCorner(2, 2) = algebra::root(Q.bottomRightCorner(2, 2));
}

void Simulator::open(Reporter& /*reporter*/) {
  if (!is_recorded()) return;
  record_ = place_->read();
  discretize(record_.interval);
}

void Simulator::initialise(std::uint64_t seed, const MemoryView& bytes) const {
  Memory& memory = bytes[memory_];
  memory.engine = random::stream(seed, "ship");
  memory.next = truth;
  States w(F_.rows());
  for (Eigen::Index i = 0; i < w.size(); ++i) w[i] = random::normal(memory.engine);
  Eigen::Map<States, Eigen::Unaligned>(memory.x, w.size()) = root_P_ * w;
}

bool Simulator::is_over(const Memory& memory) const {
  if (memory.sample < 0) return true;
  return is_recorded() ? memory.sample >= static_cast<std::int64_t>(record_.times.size())
                       : memory.sample > duration_ / interval_;
}

SourceStatus Simulator::next(const MemoryView& bytes, SourceOutput& output) const {
  Memory& memory = bytes[memory_];
  if (is_over(memory)) return SourceStatus::end;
  Eigen::Map<States, Eigen::Unaligned> x(memory.x, F_.rows());
  const auto row = static_cast<std::size_t>(memory.sample);
  const double angle = is_recorded() ? record_.values[memory.sample] : x[0];
  const bool is_truth = memory.next == truth;
  SampleWriter& out = output.on(is_truth ? truth_channel_ : gyro_channel_);
  out.t = is_recorded() ? record_.times[row] : memory.sample * interval_;
  memory.next = is_truth ? gyro : truth;
  if (is_truth) {
    out[angle_] = angle;
    if (!is_recorded()) out[rate_] = x[1];
    out[error_] = x[order_];
    out[drift_] = x[order_ + 1];
    return SourceStatus::sample;
  }
  out[reading_] = angle + x[order_] + noise_ * random::normal(memory.engine);
  States w(x.size());
  for (Eigen::Index i = 0; i < w.size(); ++i) w[i] = random::normal(memory.engine);
  x = (Phi_ * x + root_Q_ * w).eval();
  ++memory.sample;
  return SourceStatus::sample;
}

}  // namespace binnacle::ship_motion
