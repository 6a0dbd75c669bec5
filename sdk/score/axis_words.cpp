// SPDX-License-Identifier: Apache-2.0
#include "axis_words.hpp"

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>

#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr double gravity = 9.81, least_seconds = 60;
constexpr double most_force = 1.05, least_force = 0.5;  // over gravity; a vehicle that tilts has less in the mean
constexpr double least_explained = 0.6, sigmas = 5, limit = 0.1;
constexpr double half = 0.5;  // cosine of 60 deg

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
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

/// `down`: along the axes of the accelerometers.
Turn judged(const LinearFit<4>& turn, const Eigen::Vector3d& down) {
  using enum Turn::Kind;
  if (!turn.is_determined || turn.explained < least_explained) return {};
  const Eigen::Vector3d w = turn.coefficients.head<3>();
  const double about = w.dot(down), sigma = std::sqrt(down.dot(turn.covariance.topLeftCorner<3, 3>() * down));
  const double off = (w - about * down).norm();
  const double off_sigma = std::sqrt(turn.covariance.topLeftCorner<3, 3>().trace());
  if (std::abs(about) < half * w.norm()) return {off > sigmas * off_sigma ? elsewhere : unknown};
  if (std::abs(about) < sigmas * sigma) return {};
  const double scale = 1 / std::abs(about), error = sigma / std::abs(about);
  const bool is_off =
      std::abs(scale - 1) > limit + (1 - turn.explained) && std::abs(scale - 1) > sigmas * error * scale;
  return {about < 0 ? opposite : right, is_off ? scale : 1};
}

/// Whether the axes along which the vehicle speeds up and is pulled aside make a right hand with down: 1, −1, 0: unknown.
int handedness(const InputFit::Axes& axes, const Eigen::Vector3d& down) {
  for (const auto* fit : {&axes.ahead, &axes.aside})
    if (!fit->is_determined || fit->explained < least_explained) return 0;
  const Eigen::Vector3d ahead = axes.ahead.coefficients.head<3>(), aside = axes.aside.coefficients.head<3>();
  const double volume = ahead.cross(aside).dot(down) / (ahead.norm() * aside.norm());
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
    all.push_back("the mean specific force" + its + " is " + number(force) +
                  " times gravity: is its unit or scale wrong?");
  const Eigen::Vector3d down = -axes.force.normalized();
  const Turn turn = judged(axes.turn, down);
  const int hand = handedness(axes, down);
  const std::string vertical = axis(-down, input.force);
  if (turn.kind == opposite && hand < 0) {
    all.push_back(velocity_is_right
                      ? "gyros and curves say that the vertical axis" + its +
                            " is the other way round: is the sign of " + vertical.substr(1) + " wrong?"
                      : course + " is mirrored against the turns" + its + ": are " + in_quotes(fix.velocity.name[0]) +
                            " and " + in_quotes(fix.velocity.name[1]) + " swapped, or is one's sign wrong?");
    return all;
  }
  if (turn.kind == opposite)
    all.push_back("the gyros" + its + " turn against " + course + ": is the sign of " +
                  axis(down, input.turn).substr(1) + " wrong?");
  if (turn.kind == elsewhere)
    all.push_back("the gyros" + its + " turn with " + course + " about " +
                  axis(axes.turn.coefficients.head<3>(), input.turn) +
                  ", while the vertical of the accelerometers is " + vertical + ": are axes swapped?");
  if (turn.scale != 1)
    all.push_back("the turns of the gyros" + its + " are " + number(turn.scale) + " times those of " + course +
                  ": is their unit or scale wrong?");
  if (hand < 0)
    all.push_back("the accelerometers" + its + " feel acceleration ahead along " +
                  axis(axes.ahead.coefficients.head<3>(), input.force) + ", to the right along " +
                  axis(axes.aside.coefficients.head<3>(), input.force) + " and the ground's support along " + vertical +
                  ": that is a left hand; are two axes swapped, or is a sign wrong?");
  return all;
}

}  // namespace binnacle::score
