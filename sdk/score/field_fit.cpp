// SPDX-License-Identifier: Apache-2.0
#include "field_fit.hpp"

#include <Eigen/LU>

#include <cmath>
#include <numbers>
#include <utility>

#include "binnacle/geodesy.hpp"
#include "linear_fit.hpp"
#include "wording/short_number.hpp"
#include "wording/wording.hpp"

namespace binnacle::score {

using namespace wording;

namespace {

constexpr Time window_length = 4 * nanoseconds_per_second, longest_gap = 3 * nanoseconds_per_second;
constexpr double least_windows = 12,
                 least_field_speed = 0.5;  // windows; m/s of a field, what others show of it left out
constexpr double least_of_field = 0.95, field_tolerance = 0.05;
constexpr std::array<std::pair<const char*, const char*>, 3> ways{
    {{"north", "south"}, {"east", "west"}, {"down", "up"}}};

Eigen::Vector3d displacement(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const auto radii = geodesy::radii(from[0]);
  return {(to[0] - from[0]) * (radii.meridian + from[2]),
          std::remainder(to[1] - from[1], 2 * std::numbers::pi) * (radii.transverse + from[2]) * std::cos(from[0]),
          from[2] - to[2]};
}

}  // namespace

void FieldFit::add(Time t, const Eigen::Vector3d& position, const Eigen::Vector3d& velocity) {
  if (!position.allFinite() || !velocity.allFinite() || (last_ != no_time && t <= last_)) return;
  const bool goes_on = last_ != no_time && t - last_ <= longest_gap;
  if (goes_on) way_ += 0.5 * seconds(t - last_) * (last_velocity_ + velocity);
  last_ = t;
  last_velocity_ = velocity;
  if (goes_on && t - begin_ < window_length) return;
  if (goes_on) {
    const double dt = seconds(t - begin_);
    const Eigen::Vector3d v = way_ / dt;
    const auto take = [&](Sums& sums, const Eigen::Vector3d& went) {
      sums.vd += v * went.transpose();
      sums.dd += went.cwiseAbs2();
    };
    vv_ += v * v.transpose();
    take(as_labelled_, displacement(begin_position_, position) / dt);
    const auto exchanged = [](const Eigen::Vector3d& p) { return Eigen::Vector3d(p[1], p[0], p[2]); };
    take(exchanged_, displacement(exchanged(begin_position_), exchanged(position)) / dt);
    ++count_;
  }
  begin_ = t;
  begin_position_ = position;
  way_.setZero();
}

bool FieldFit::Fitted::is_wrong(int row, int column, double by) const {
  const double off = std::abs(matrix(row, column) - (row == column));
  return is_moving[as_size(column)] && is_explained[as_size(row)] && off > by &&
         off > clear_sigmas * sigma(row, column);
}

bool FieldFit::Fitted::is_identity() const {
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column)
      if (is_wrong(row, column, field_tolerance) || !is_moving[as_size(column)] || !is_explained[as_size(row)])
        return false;
  return true;
}

/// Where the third field hardly changes, the first two are judged without it.
FieldFit::Fitted FieldFit::fitted(bool is_exchanged) const {
  Fitted fitted;
  if (count_ < least_windows) return fitted;
  const Sums& sums = is_exchanged ? exchanged_ : as_labelled_;
  const auto keep = [&](int row, int columns, const auto& its) {
    if (!its.is_determined) return;
    fitted.is_explained[as_size(row)] = its.explained > least_of_field;
    for (int column = 0; column < columns; ++column) {
      fitted.matrix(row, column) = its.coefficients[column];
      fitted.sigma(row, column) = std::sqrt(its.covariance(column, column));
    }
  };
  const auto moves = [&](const auto& products, int column) {
    const auto inverse = products.inverse().eval();
    return std::isfinite(inverse(column, column)) &&
           1 / (inverse(column, column) * count_) > least_field_speed * least_field_speed;
  };
  const Eigen::Matrix2d level = vv_.topLeftCorner<2, 2>();
  const bool has_third = moves(vv_, 0) && moves(vv_, 1) && moves(vv_, 2);
  for (int column = 0; column < 2; ++column) fitted.is_moving[as_size(column)] = moves(level, column);
  fitted.is_moving[2] = has_third;
  for (int row = 0; row < 3; ++row) {
    const Eigen::Vector3d vd = sums.vd.col(row);
    if (has_third)
      keep(row, 3, fit<3>(vv_, vd, sums.dd[row], count_));
    else if (row < 2)
      keep(row, 2, fit<2>(level, Eigen::Vector2d(vd.head<2>()), sums.dd[row], count_));
  }
  return fitted;
}

bool FieldFit::is_right() const { return fitted(false).is_identity(); }

void FieldFit::exchange(StateBytes& bytes) {
  bytes.value(begin_);
  bytes.value(last_);
  for (auto* vector : {&begin_position_, &last_velocity_, &way_}) bytes.matrix(*vector);
  bytes.matrix(vv_);
  for (auto* sums : {&as_labelled_, &exchanged_}) {
    bytes.matrix(sums->vd);
    bytes.matrix(sums->dd);
  }
  bytes.value(count_);
}

std::vector<std::string> FieldFit::words(const FixFields& fix) const {
  std::vector<std::string> all;
  const Fitted its = fitted(false);
  const auto name = [&](int field) { return in_quotes(fix.velocity.name[as_size(field)]); };
  const std::string where = " of " + in_quotes(fix.channel_name);
  if (!its.is_identity() && fix.position && fitted(true).is_identity()) {
    const auto& names = fix.position->name;
    return {"the position" + where + " moves as its velocity does only if " + in_quotes(names[0]) + " and " +
            in_quotes(names[1]) + " change places: are they swapped?"};
  }
  const auto is_main = [&](int row, int column) {
    int main = 0;
    its.matrix.col(column).cwiseAbs().maxCoeff(&main);
    return main == row && its.is_wrong(row, column, field_tolerance);
  };
  for (int field = 0; field < 3; ++field) {
    int main = 0;
    its.matrix.col(field).cwiseAbs().maxCoeff(&main);
    if (!its.is_wrong(field, field, field_tolerance) && !its.is_wrong(main, field, field_tolerance)) continue;
    if (main < field && is_main(field, main)) continue;  // the other half of what was said
    const double share = its.matrix(main, field);
    const auto& [there, back] = ways[as_size(main)];
    const std::string follows = "the velocity field " + name(field) + where + " follows the motion " +
                                (share < 0 ? back : there) + ", as its position shows it";
    const bool is_partly =
        its.is_wrong((field + 1) % 3, field, field_tolerance) || its.is_wrong((field + 2) % 3, field, field_tolerance);
    if (main != field)
      all.push_back(follows + ": are " + name(std::min(field, main)) + " and " + name(std::max(field, main)) +
                    " swapped?");
    else if (is_partly)
      all.push_back(follows + ", only in part: is it along other axes?");
    else if (share < 0)
      all.push_back(follows + ": is its sign wrong?");
    else
      all.push_back("the velocity field " + name(field) + where + " is " + short_number(1 / share) +
                    " times the motion " + there + ", as its position shows it: is its unit or scale wrong?");
  }
  return all;
}

}  // namespace binnacle::score
