// SPDX-License-Identifier: Apache-2.0
#include "input_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr Time shortest_step = 400 * (nanoseconds_per_second / 1000),
               longest_step = 2500 * (nanoseconds_per_second / 1000);
constexpr double least_fix_speed = 2, most_turn = 1.5;  // m/s, rad
constexpr double least_intervals = 40;
constexpr double independent = 0.5;  // of the rows: neighbours have a sample of velocity in common
constexpr double least_of_rows = 0.6, least_shift = 0.05;
constexpr double longest_arm = 20;  // m, to an antenna
constexpr std::size_t apart =
    15;  // steps: a second shift that fits as well, this far from the best, makes both worthless

}  // namespace

/// The fits at the best shift.
struct InputFit::Best {
  std::size_t shift = most_steps;
  double margin = 0;            // to the next that is apart
  Minimum by_speed, by_course;  // near the best
  LinearFit<4> turn, ahead, aside;
};

InputFit::InputFit() : waiting_(160), sums_(shifts) {}

void InputFit::add_input(Time t0, Time t, const Turns& increment) {
  history_.add(t0, t, increment);
  if (waiting_count_ > 0) work_off();
}

void InputFit::add_velocity(Time t, double north, double east) {
  if (!std::isfinite(north) || !std::isfinite(east) || (last_ != no_time && t < last_ + shortest_step)) return;
  const double before = std::hypot(north_, east_), now = std::hypot(north, east);
  if (last_ != no_time && t - last_ <= longest_step && std::min(before, now) > least_fix_speed) {
    const double turn = std::atan2(north_ * east - east_ * north, north_ * north + east_ * east);
    if (waiting_count_ == waiting_.size()) {
      first_ = (first_ + 1) % waiting_.size();
      --waiting_count_;
    }
    if (std::abs(turn) < most_turn)
      waiting_[(first_ + waiting_count_++) % waiting_.size()] = {last_, t, turn, now - before, 0.5 * (before + now)};
  }
  last_ = t;
  north_ = north;
  east_ = east;
}

void InputFit::exchange(StateBytes& bytes) {
  history_.exchange(bytes);
  bytes.list(waiting_);
  bytes.value(first_);
  bytes.value(waiting_count_);
  bytes.value(last_);
  for (double* number : {&north_, &east_, &turn2_, &ahead2_, &aside2_, &speed_sum_, &count_}) bytes.value(*number);
  for (Sums& sums : sums_) {
    for (auto* products : {&sums.gyro, &sums.accel}) bytes.matrix(*products);
    for (auto* with : {&sums.turn, &sums.ahead, &sums.aside}) bytes.matrix(*with);
  }
}

void InputFit::work_off() {
  constexpr Time reach = most_steps * InputHistory::step;
  for (; waiting_count_ > 0; first_ = (first_ + 1) % waiting_.size(), --waiting_count_) {
    const Leg& leg = waiting_[first_];
    if (history_.is_past(leg.from - reach)) continue;
    if (!history_.has(leg.from - reach, leg.to + reach)) return;
    take(leg);
  }
}

/// A row of the turn counts less where the vehicle is slow and its course uncertain.
void InputFit::take(const Leg& leg) {
  const double weight = leg.speed / (leg.speed + 5), dt = seconds(leg.to - leg.from);
  const double turn = weight * leg.turn, aside = leg.speed * leg.turn;
  const std::int64_t a = InputHistory::node(leg.from), b = InputHistory::node(leg.to);
  const double in_a = seconds(leg.from - a * InputHistory::step) / seconds(InputHistory::step);
  const double in_b = seconds(leg.to - b * InputHistory::step) / seconds(InputHistory::step);
  for (std::size_t i = 0; i < shifts; ++i) {
    const std::int64_t back = static_cast<std::int64_t>(i) - most_steps;
    const Turns from = (1 - in_a) * history_.at(a - back) + in_a * history_.at(a - back + 1);
    const Turns over = (1 - in_b) * history_.at(b - back) + in_b * history_.at(b - back + 1) - from;
    const Eigen::Vector4d gyro(weight * over[0], weight * over[1], weight * over[2], weight * dt);
    const Eigen::Vector4d accel(over[3], over[4], over[5], dt);
    Sums& sums = sums_[i];
    sums.gyro.noalias() += gyro * gyro.transpose();
    sums.accel.noalias() += accel * accel.transpose();
    sums.turn += turn * gyro;
    sums.ahead += leg.faster * accel;
    sums.aside += aside * accel;
  }
  turn2_ += turn * turn;
  ahead2_ += leg.faster * leg.faster;
  aside2_ += aside * aside;
  speed_sum_ += leg.speed;
  ++count_;
}

/// −2 ln of the likelihood of each shift, but for what all have in common.
InputFit::Misfits InputFit::misfits(const Eigen::Matrix4d Sums::*products, const Eigen::Vector4d Sums::*with,
                                    double squares) const {
  Misfits all;
  for (std::size_t i = 0; i < shifts; ++i) {
    const auto its = fit<4>(sums_[i].*products, sums_[i].*with, squares, count_);
    all[i] = its.is_determined ? independent * count_ * std::log(its.squares / squares) : 0;
  }
  return all;
}

/// The least within a second of `near`, by a parabola.
InputFit::Minimum InputFit::minimum(const Misfits& misfits, std::size_t near) {
  constexpr std::size_t second = nanoseconds_per_second / InputHistory::step;
  const double step = binnacle::seconds(InputHistory::step);
  const auto from = misfits.begin() + static_cast<std::ptrdiff_t>(near - std::min(near, second));
  const auto to = misfits.begin() + static_cast<std::ptrdiff_t>(std::min(near + second + 1, shifts));
  const auto at = std::min_element(from, to);
  Minimum its;
  if (at == misfits.begin() || at + 1 == misfits.end() || at == from || at + 1 == to) return its;
  const double left = at[-1], right = at[1], bend = left + right - 2 * at[0];
  if (!(bend > 0)) return its;
  its.seconds = (static_cast<double>(at - misfits.begin()) - most_steps + 0.5 * (left - right) / bend) * step;
  its.sigma = step * std::sqrt(2 / bend);
  its.gain = misfits[most_steps] - at[0];
  return its;
}

InputFit::Best InputFit::best() const {
  Best best;
  if (count_ < least_intervals) return best;
  const Misfits course = misfits(&Sums::gyro, &Sums::turn, turn2_),
                speed = misfits(&Sums::accel, &Sums::ahead, ahead2_);
  Misfits both;
  std::transform(course.begin(), course.end(), speed.begin(), both.begin(), std::plus<>());
  best.shift = static_cast<std::size_t>(std::min_element(both.begin(), both.end()) - both.begin());
  double second = 0;
  for (std::size_t i = 0; i < shifts; ++i)
    if (i + apart < best.shift || i > best.shift + apart) second = std::min(second, both[i]);
  best.margin = second - both[best.shift];
  best.by_speed = minimum(speed, best.shift);
  best.by_course = minimum(course, best.shift);
  const Sums& sums = sums_[best.shift];
  best.turn = fit<4>(sums.gyro, sums.turn, turn2_, count_);
  best.ahead = fit<4>(sums.accel, sums.ahead, ahead2_, count_);
  best.aside = fit<4>(sums.accel, sums.aside, aside2_, count_);
  return best;
}

/// An antenna that is ahead of the rear axle by l turns its course earlier by l/v than the vehicle its heading: so the
/// course alone shows a shift only if no such lever arm can be meant.
std::optional<InputFit::Shift> InputFit::shift() const {
  const Best its = best();
  if (its.margin < clear_sigmas * clear_sigmas) return std::nullopt;
  const bool has_speed = its.ahead.explained > least_of_rows;
  const Minimum& found = has_speed ? its.by_speed : its.by_course;
  const double least = has_speed ? least_shift : longest_arm / (speed_sum_ / count_);
  const bool is_clear = found.sigma > 0 && found.gain > clear_sigmas * clear_sigmas &&
                        (has_speed || its.turn.explained > least_of_rows) &&
                        std::abs(found.seconds) > std::max(least, clear_sigmas * found.sigma);
  if (!is_clear) return std::nullopt;
  return Shift{found.seconds, found.sigma};
}

std::string InputFit::figures() const {
  const Best its = best();
  char text[400];
  const auto& u = its.turn.coefficients;
  const auto& a = its.ahead.coefficients;
  const auto& l = its.aside.coefficients;
  const Eigen::Vector3d f = history_.mean_force();
  std::snprintf(text, sizeof text,
                "n %.0f speed %.3f±%.3f gain %.1f course %.3f±%.3f margin %.1f R2 %.3f %.3f %.3f turn %.3f %.3f %.3f "
                "ahead %.3f %.3f %.3f aside "
                "%.3f %.3f %.3f f %.2f %.2f %.2f",
                count_, its.by_speed.seconds, its.by_speed.sigma, its.by_speed.gain, its.by_course.seconds,
                its.by_course.sigma, its.margin, its.turn.explained, its.ahead.explained, its.aside.explained, u[0],
                u[1], u[2], a[0], a[1], a[2], l[0], l[1], l[2], f[0], f[1], f[2]);
  return text;
}

InputFit::Axes InputFit::axes() const {
  const Best its = best();
  const Sums& sums = sums_[its.shift];
  const Eigen::Vector3d force = history_.mean_force();
  Eigen::Matrix<double, 4, 2> vertical = Eigen::Matrix<double, 4, 2>::Zero();
  vertical.col(0).head<3>() = -force.normalized();
  vertical(3, 1) = 1;
  const Eigen::Matrix2d XtX = vertical.transpose() * sums.gyro * vertical;
  const Eigen::Vector2d Xty = vertical.transpose() * sums.turn;
  return {its.turn, fit<2>(XtX, Xty, turn2_, count_), its.ahead, its.aside, force, history_.seconds()};
}

}  // namespace binnacle::score
