// SPDX-License-Identifier: Apache-2.0
// What is asked of the data, a file each: each adds what it finds.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "binnacle/unit.hpp"
#include "inspect/inspect.hpp"
#include "lever_arm.hpp"
#include "series.hpp"

namespace binnacle::inspect {

inline constexpr double degrees = 57.29577951308232;  // per radian

/// "12.3", four significant digits.
std::string figure(double value);
/// A patch of one value: {"sources": {CHANNEL: …}}.
Json source_patch(const Channel& channel, const Json& of_source);
/// A patch of columns: each of `fields` gets `what`.
Json column_patch(const Channel& channel, const std::vector<std::string>& fields, const Json& what);

// ---- one channel, as it was recorded
/// Span, rate, jitter, gaps, duplicates, time going back, unit of labels, time base.
void ask_stamps(const Channel& channel, Findings& findings);
/// Returns the factor that labels need to be seconds (1, 1e-3, …), with its finding.
double label_factor(const Channel& channel, Findings& findings);
/// NaN, empty, constant, stuck, quantized, clipped fields, spikes, standard deviations.
void ask_fields(const Channel& channel, Findings& findings);

// ---- an inertial channel
struct Rest {
  double from = 0, to = 0;
};
struct RestFigures {
  std::vector<Rest> spans;
  Vector3d mean_w, mean_f, sigma_w, sigma_f;  // over all of them
  double seconds = 0;
  bool is_seen = false;  // by velocities; else a vehicle that moves evenly looks the same
};
/// The quietest seconds; where fixes are given (aligned), none at which they move.
RestFigures find_rest(const Inertial& inertial, const Fixes* fixes = nullptr, double delay = 0);
/// Unit of specific force by gravity: corrects `inertial`, returns the factor.
double ask_force_unit(const Channel& channel, Inertial& inertial, Findings& findings);
void ask_rest(const Channel& channel, const Inertial& inertial, const RestFigures& rest, Findings& findings);
/// How fixes scatter at rest. `delay`: of their labels against those of the rest [s].
void ask_fix_noise(const Channel& channel, const Fixes& fixes, double delay, const RestFigures& rest,
                   Findings& findings);
/// How the record begins: rest, and moving off; nothing where it begins otherwise.
std::optional<Start> start_of(const Inertial& inertial, const Fixes& fixes, double delay, const RestFigures& rest,
                              const Matrix3d& C_vb);
void ask_vibration(const Channel& channel, const Inertial& inertial, const RestFigures& rest, Findings& findings);

// ---- a channel of fixes
/// Velocity against differences of position: units, signs, order; corrects the velocities of `fixes`.
struct VelocityRelation {
  bool is_mirrored = false;     // one horizontal axis has another sign: of the velocity, or of the position
  int axis = 1;                 // 0 north, 1 east
  bool is_upside_down = false;  // vd and height go together with the wrong sign
  double vertical_slope = 1;
};
VelocityRelation ask_velocity(const Channel& channel, Fixes& fixes, Findings& findings);
void report_mirrored(const Channel& channel, int axis, bool is_known, bool velocity_is_at_fault, Findings& findings);
void report_upside_down(const Channel& channel, double slope, bool is_known, bool velocity_is_at_fault,
                        Findings& findings);
void ask_frozen(const Channel& channel, const Fixes& fixes, Findings& findings);
void ask_deviations(const Channel& channel, const Fixes& fixes, Findings& findings);
void ask_heading(const Channel& channel, const Fixes& fixes, Findings& findings);

// ---- an inertial channel and fixes
/// Turning: course rate = axis · rate + bias. |axis| is 1 where rates are rad/s; its direction is down.
struct Turning {
  bool is_known = false;
  Vector3d axis = Vector3d::Zero(), axis_error = Vector3d::Zero();
  double bias = 0, explained = 0;
  std::size_t used = 0;
  /// The same factor with the axis held along gravity; 0: that explains less than half. A car leans as its rate of turn changes, so an
  /// error of the delay makes the fitted axis lean, and longer than it is. Where triads differ, only the fitted axis is right.
  double along_gravity = 0, along_gravity_error = 0;
};
/// Where fixes are `delay` late against the labels of the IMU. up: mean specific force, any length.
Turning turning_at(const Integral& rates, const Fixes& fixes, double delay, const Vector3d& up);
/// The clocks: a coarse delay by turning. Nothing where the data show none.
std::optional<double> ask_clocks(const Channel& imu, const Channel& gnss, const Inertial& inertial, const Fixes& fixes,
                                 double label_difference, Findings& findings, std::vector<Plot>& plots);
double ask_rate_unit(const Channel& channel, Inertial& inertial, const Turning& turning, Findings& findings);
/// Which signed columns the triads have, against each other and against a right-handed frame.
struct Axes {
  bool is_known = false;
  bool is_ruled_out = false;              // not known, but not those of the file
  Matrix3d force = Matrix3d::Identity();  // true components = force · those of the file
  Matrix3d rate = Matrix3d::Identity();
  bool is_mirrored = false;  // rates and forces alike
};
Axes ask_axes(const Channel& imu, const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias,
              Findings* findings);
/// 1: vd goes with the specific force as it is; -1: with its other sign; 0: it is not to be seen.
int sign_of_down(const Inertial& inertial, const Fixes& fixes, double delay, const Vector3d& bias);
/// The delay to a fraction of a step, with its standard error; from the specific force as well as from turning.
double ask_delay(const Channel& imu, const Channel& gnss, const Inertial& inertial, const Fixes& fixes, double coarse,
                 const Vector3d& bias, double label_difference, Findings& findings);
/// C_vb, by course, climb and the attitudes that fit velocities to specific force. lever_arm: what goes best with this delay. antenna: with
/// the delay and the biases as unknowns of their own, as it is reported.
std::optional<Matrix3d> ask_mounting(const Channel& imu, const Channel& gnss, const Inertial& inertial,
                                     const Fixes& fixes, double delay, const Vector3d& bias, const RestFigures& rest,
                                     Vector3d& lever_arm, LeverArm& antenna, Findings& findings);
/// Spans in which velocities contradict the specific force.
void ask_velocity_faults(const Channel& gnss, const Inertial& inertial, const Fixes& fixes, double delay,
                         const Vector3d& bias, const Vector3d& lever_arm, Findings& findings, std::vector<Plot>& plots);

/// Warnings first, otherwise in their order.
void sort(Findings& findings);

}  // namespace binnacle::inspect
