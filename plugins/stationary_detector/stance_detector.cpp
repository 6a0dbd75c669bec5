// SPDX-License-Identifier: Apache-2.0
// The stance_detector transform: from the inertial samples of a foot to a channel that emits while it stands.
#include "stance_detector.hpp"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "binnacle/view.hpp"

namespace binnacle::stationary_detector {

namespace {

using Eigen::Vector3d;

std::vector<FieldSpec> imu_fields() {
  std::vector<FieldSpec> fields;
  for (const char* name : {"wx", "wy", "wz"}) fields.push_back(field::rate(name, "rad/s").about("sensor axes"));
  for (const char* name : {"fx", "fy", "fz"}) fields.push_back(field::rate(name, "m/s^2").about("sensor axes"));
  return fields;
}

}  // namespace

/// The newest W samples, a ring. All zero is an empty window.
struct StanceDetector::Memory {
  struct Sample {
    double rate[3], force[3];
  };
  Sample window[most_samples] = {};
  std::int64_t next = 0, count = 0;
  Time t = no_time;          // of the last sample; no_time: none yet
  double gyro_bias[3] = {};  // rad/s, the latest

  void empty() { next = count = 0; }
};

ComponentSpec StanceDetector::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "stance_detector";
  spec.summary = "Detects from inertial samples on a foot when it stands on the ground.";
  spec.source =
      "I. Skog, P. Händel, J.-O. Nilsson, J. Rantakokko, Zero-velocity detection: an algorithm evaluation, IEEE Trans. "
      "Biomed. Eng. 57 (2010), 2657-2666: the generalized likelihood ratio test of angular rate and specific force";
  spec.parameters = {
      integer("samples")
          .at_least(2)
          .at_most(most_samples)
          .defaults("5")
          .about("number W of consecutive samples in the window"),
      number("force_sigma", "m/s^2")
          .above(0)
          .defaults("0.01")
          .about("standard deviation of a sample of specific force, in a stance"),
      number("rate_sigma", "rad/s")
          .above(0)
          .defaults("\"0.1 deg/s\"")
          .about("standard deviation of a sample of angular rate, in a stance"),
      number("gravity", "m/s^2").at_least(9).at_most(11).defaults("9.8").about("length of the specific force at rest"),
      number("threshold", "1").above(0).defaults("3e4").about("threshold gamma, below which the foot stands"),
      parameter::time("max_gap")
          .above(0)
          .defaults("\"50 ms\"")
          .about("longest hole in the samples; a longer hole clears the window"),
  };
  std::vector<FieldSpec> bias;
  for (const char* name : {"x", "y", "z"}) bias.push_back(field::level(name, "rad/s").about("gyroscope bias"));
  spec.inputs = {input("imu", imu_fields()).about("the inertial sensor on the foot"),
                 input("gyro_bias", bias).optional().about("latest bias, subtracted from the rates")};
  spec.example = R"json({"input": "imu", "threshold": 3e4})json";
  return spec;
}

StanceDetector::StanceDetector(const Binding& binding)
    : samples_(static_cast<int>(binding.parameters().integer("samples"))),
      force_sigma_(binding.parameters().number("force_sigma")),
      rate_sigma_(binding.parameters().number("rate_sigma")),
      gravity_(binding.parameters().number("gravity")),
      threshold_(binding.parameters().number("threshold")),
      max_gap_(binding.parameters().time("max_gap")),
      imu_(binding.input("imu")),
      gyro_bias_(binding.input("gyro_bias")),
      w_(binding.fields(imu_, "wx", "wy", "wz")),
      f_(binding.fields(imu_, "fx", "fy", "fz")),
      bias_(binding.fields(gyro_bias_, "x", "y", "z")) {
  declare_channels();
  memory_ = declaration_.keeps<Memory>();
}

void StanceDetector::declare_channels() {
  ChannelDeclaration standing("standing"), state("state");
  const std::vector<FieldSpec> fields = imu_fields();
  standing_w_ = standing.carries(std::array<FieldSpec, 3>{fields[0], fields[1], fields[2]});
  standing_f_ = standing.carries(std::array<FieldSpec, 3>{fields[3], fields[4], fields[5]});
  standing.max_interval = max_gap_;
  is_standing_ = state.carries(field::level("standing", "1").about("1 while it stands, else 0"));
  statistic_ = state.carries(field::level("statistic", "1").about("T, which the threshold is for"));
  standing_channel_ = declaration_.emits(std::move(standing));
  state_channel_ = declaration_.emits(std::move(state));
}

void StanceDetector::on(const TransformInput& in, Emitter& emitter) const {
  Memory& memory = in.memory[memory_];
  if (in.from == imu_) return on_imu(in.sample, memory, emitter);
  const Vector3d bias = in.sample[bias_];
  if (bias.allFinite()) vector_at<3>(memory.gyro_bias) = bias;
}

void StanceDetector::on_imu(const SampleView& sample, Memory& memory, Emitter& emitter) const {
  const Vector3d rate = sample[w_], force = sample[f_];
  if (!rate.allFinite() || !force.allFinite()) return memory.empty();  // nobody knows what the foot did
  if (sample.t == memory.t) return;
  const Time before = memory.t;
  memory.t = sample.t;
  if (before == no_time || sample.t < before || sample.t - before > max_gap_) memory.empty();
  if (memory.next < 0 || memory.next >= samples_ || memory.count < 0) memory.empty();  // of a forged snapshot
  Memory::Sample& newest = memory.window[memory.next];
  vector_at<3>(newest.rate) = rate - vector_at<3>(memory.gyro_bias);
  vector_at<3>(newest.force) = force;
  memory.next = (memory.next + 1) % samples_;
  memory.count = memory.count < samples_ ? memory.count + 1 : samples_;
  if (memory.count < samples_) return;

  const double statistic = this->statistic(memory);
  const bool stands = statistic < threshold_;
  SampleWriter& state = emitter.on(state_channel_);
  state.t = sample.t;
  state[is_standing_] = stands ? 1.0 : 0.0;
  state[statistic_] = statistic;
  emitter.emit(state_channel_);
  if (!stands) return;
  SampleWriter& out = emitter.on(standing_channel_);
  out.t = sample.t;
  out.t0 = before;
  out[standing_w_] = rate;
  out[standing_f_] = force;
  emitter.emit(standing_channel_);
}

double StanceDetector::statistic(const Memory& memory) const {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < samples_; ++k) sum += vector_at<3>(memory.window[k].force);
  const double length = sum.norm();
  const Vector3d at_rest = length > 0 ? Vector3d(gravity_ / length * sum) : Vector3d::Zero();
  double total = 0;
  for (int k = 0; k < samples_; ++k) {
    total += (vector_at<3>(memory.window[k].force) - at_rest).squaredNorm() / (force_sigma_ * force_sigma_);
    total += vector_at<3>(memory.window[k].rate).squaredNorm() / (rate_sigma_ * rate_sigma_);
  }
  return total / samples_;
}

}  // namespace binnacle::stationary_detector
