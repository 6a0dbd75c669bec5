// SPDX-License-Identifier: Apache-2.0
// A process model that navigates by an inertial sensor, whatever its error model.
#pragma once

#include <array>
#include <vector>

#include "attitude/algorithm.hpp"
#include "binnacle/process_model.hpp"
#include "binnacle/spec.hpp"
#include "inertial/sample_memory.hpp"
#include "strapdown/error_model.hpp"
#include "strapdown/mechanization.hpp"

namespace binnacle::inertial {

class SampleGroup;

/// The error model of one sample, or of a group of them.
struct Linearized {
  strapdown::TransitionBlocks transition;
  strapdown::NoiseBlocks noise;
};

/// One step as an error model sees it.
struct StepTaken {
  const strapdown::Navigation& before;
  const strapdown::Step& advanced;
  const strapdown::InputSensitivity& input;
  strapdown::Order order;
  bool has_sensor_errors;    ///< a block of them is plugged in: `input` and the blocks of their columns are wanted
  bool has_position_errors;  ///< blocks with rows or columns of the position are wanted
};

/// What an inertial plugin brings of its own: Φ of one step.
struct ErrorModel {
  strapdown::TransitionBlocks (*transition)(const StepTaken&);
  bool attitude_moves_alone = false;  ///< neither position nor velocity nor specific force couples into it
};

/// Advances position, velocity and attitude by an inertial sensor's increments (strapdown/mechanization.hpp), after
/// taking off the bias and scale factor blocks that are plugged in (strapdown/error_model.hpp: signs).
///
/// Whole samples go by the attitude algorithm chosen, as many at a time as it takes; what a measurement left over of a
/// group goes by the algorithm for so many, and a single sample or a fragment by that for one.
///
/// Several updates in one step are folded: Φ = Φ_n … Φ_1, Q = Φ_n Q Φ_nᵀ + Q_n. Blocks of such a product which the
/// declaration lacks are of the order that is neglected anyway.
///
/// While the input `standing` says 1, Φ and Q are those of f_n = (0, 0, −g).
class InertialProcess : public ProcessModel {
 public:
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 protected:
  /// Adds parameters, ports and fields that every such model has.
  static void describe(ComponentSpec& spec);
  InertialProcess(const Binding& binding, ErrorModel model);

 private:
  /// A declared block, and which of the error model's stands there.
  struct Transition {
    PhiBlock place;
    Eigen::Matrix3d strapdown::TransitionBlocks::*block;
    bool is_own;  // of a port on itself
  };
  struct Noise {
    QBlock place;
    Eigen::Matrix3d strapdown::NoiseBlocks::*block;
  };

  strapdown::BodyMotion motion(const SampleGroup& group, const strapdown::SensorErrors& errors,
                               SampleMemory& remembered) const;
  strapdown::Increment corrected(const strapdown::Increment& measured, const strapdown::SensorErrors& errors) const;
  strapdown::MeanRates corrected(const strapdown::MeanRates& measured, const strapdown::SensorErrors& errors) const;
  strapdown::NoiseDensity density(const Step& step) const;
  bool stands(const ProcessInput& in) const;
  strapdown::SensorErrors sensor_errors(const PortValues& x) const;
  void declare_transition();
  void declare_noise();
  void write(const Linearized& linearized, const ProcessOutput& out) const;
  void write_identity(const ProcessOutput& out) const;

  std::array<Port, 7> ports_;
  SensorFields fields_;
  Input standing_;
  Field is_standing_;
  Memory<SampleMemory> memory_;
  std::vector<Transition> transition_;
  std::vector<Noise> noise_;
  ErrorModel model_;
  strapdown::Order order_;
  attitude::Algorithm algorithm_;
  bool has_sensor_errors_ = false, has_position_errors_ = true;
  strapdown::NoiseDensity density_;
  double bridge_acceleration_ = 0;                         // 1-sigma per axis, over a hole of the input [m/s²]
  Eigen::Vector3d bridge_rate_ = Eigen::Vector3d::Zero();  // [rad/s], body
};

}  // namespace binnacle::inertial
