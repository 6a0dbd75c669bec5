// SPDX-License-Identifier: Apache-2.0
#include "axis_words.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>
#include <utility>

#include "binnacle/eigen.hpp"
#include "wording/short_number.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr double gravity = 9.81, least_seconds = 60;
constexpr double most_force = 1.05, least_force = 0.5;  // over gravity; a vehicle that tilts has less in the mean
constexpr double least_of_turns = 0.6, least_scale_off = 0.1;
constexpr double half = 0.5, most_askew = 0.175;  // rad, 10 deg: suspension and slopes make some

/// The coefficients of the three axes, each over its 1-sigma.
Eigen::Vector3d significance(const LinearFit<4>& fit) {
  return fit.coefficients.head<3>().cwiseQuotient(fit.covariance.diagonal().head<3>().cwiseSqrt());
}

/// "+'fx'": the axis that the vector is nearest to.
std::string axis(const Eigen::Vector3d& along, const VectorFields& fields) {
  int main = 0;
  along.cwiseAbs().maxCoeff(&main);
  return (along[main] < 0 ? "-" : "+") + in_quotes(fields.name[as_size(main)]);
}

struct Turn {
  enum class Kind { unknown, right, opposite, elsewhere } kind = Kind::unknown;
  double scale = 1;  // measured over true, where it is significant
};

Turn judged(const InputFit::Axes& axes) {
  using enum Turn::Kind;
  const auto& vertical = axes.vertical;
  if (!vertical.is_determined || axes.turn.explained < least_of_turns) return {};
  if (vertical.explained < half * axes.turn.explained) return {elsewhere};
  const double about = vertical.coefficients[0], sigma = std::sqrt(vertical.covariance(0, 0));
  if (vertical.explained < least_of_turns || std::abs(about) < clear_sigmas * sigma) return {};
  const double scale = 1 / std::abs(about), off = std::abs(scale - 1);
  const bool is_off =
      off > least_scale_off + (1 - vertical.explained) && off > clear_sigmas * sigma / std::abs(about) * scale;
  return {about < 0 ? opposite : right, is_off ? scale : 1};
}

/// By how much the way ahead lies to the right of the first axis, and its 1-sigma [rad].
std::pair<double, double> way_ahead(const InputFit::Axes& axes, const Eigen::Vector3d& down) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), ahead = axes.ahead.coefficients.head<3>();
  const Eigen::Vector3d right = down.cross(x);
  const double along = ahead.dot((x - x.dot(down) * down).normalized()), aside = ahead.dot(right.normalized());
  const double sigma = std::sqrt(axes.ahead.covariance.topLeftCorner<2, 2>().trace()) / std::hypot(along, aside);
  return {std::atan2(aside, along), sigma};
}

/// Whether the axes along which the vehicle speeds up and is pulled aside make a right hand with down: 1, −1, 0: unknown.
int handedness(const InputFit::Axes& axes, const Eigen::Vector3d& down) {
  for (const auto* fit : {&axes.ahead, &axes.aside})
    if (!fit->is_determined || fit->explained < least_of_turns) return 0;
  const auto level = [&](const LinearFit<4>& fit) {
    const Eigen::Vector3d along = fit.coefficients.head<3>();
    return (along - along.dot(down) * down).normalized();
  };
  const double volume = level(axes.ahead).cross(level(axes.aside)).dot(down);
  return std::abs(volume) < half ? 0 : volume < 0 ? -1 : 1;
}

}  // namespace

std::vector<std::string> axis_words(const InputFit::Axes& axes, const InertialFields& input, const FixFields& fix,
                                    bool velocity_is_right) {
  using enum Turn::Kind;
  std::vector<std::string> all;
  const std::string its = " of " + in_quotes(input.channel_name),
                    course = "the course of " + in_quotes(fix.channel_name);
  const double force = axes.force.norm() / gravity;
  if (axes.seconds < least_seconds || !(force > 0)) return all;
  if (force > most_force || force < least_force)
    all.push_back("the mean specific force" + its + " is " + short_number(force) +
                  " times gravity: is its unit or scale wrong?");
  const Eigen::Vector3d down = -axes.force.normalized();
  const Turn turn = judged(axes);
  const int hand = handedness(axes, down);
  const std::string vertical = axis(-down, input.force);
  if (turn.kind == opposite && hand < 0) {
    all.push_back(velocity_is_right
                      ? "gyros and turns show that the vertical axis" + its +
                            " is the other way round: is the sign of " + vertical.substr(1) + " wrong?"
                      : course + " is mirrored against the turns" + its + ": are " + in_quotes(fix.velocity.name[0]) +
                            " and " + in_quotes(fix.velocity.name[1]) + " swapped, or is one's sign wrong?");
    return all;
  }
  if (turn.kind == opposite)
    all.push_back("the gyros" + its + " turn against " + course + ": is the sign of " +
                  axis(down, input.turn).substr(1) + " wrong?");
  if (turn.kind == elsewhere)
    all.push_back("the gyros" + its + " turn with " + course + " about " + axis(significance(axes.turn), input.turn) +
                  ", while the vertical of the accelerometers is " + vertical + ": are axes swapped?");
  if (turn.scale != 1)
    all.push_back("the turns of the gyros" + its + " are " + short_number(turn.scale) + " times those of " + course +
                  ": is their unit or scale wrong?");
  if (hand < 0)
    all.push_back("the accelerometers" + its + " measure forward acceleration along " +
                  axis(significance(axes.ahead), input.force) + ", to the right along " +
                  axis(significance(axes.aside), input.force) + " and the support of the ground along " + vertical +
                  ": these axes are left-handed; are two axes swapped, or is a sign wrong?");
  const auto [angle, sigma] = way_ahead(axes, down);
  const bool is_askew = hand > 0 && std::abs(angle) > std::max(most_askew, clear_sigmas * sigma);
  if (is_askew && std::abs(down.x()) < half && !input.rolls.empty())
    all.push_back(
        "the accelerometers" + its + " measure forward acceleration " +
        short_number(std::round(std::abs(angle) * 180 / std::numbers::pi)) + " deg to the " +
        (angle > 0 ? "right" : "left") + " of the x axis, along which " + in_quotes(input.rolls) +
        " assumes the motion of the vehicle: is the mounting of the sensor different, or are axes exchanged?");
  return all;
}

}  // namespace binnacle::score
