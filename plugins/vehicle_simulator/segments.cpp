// SPDX-License-Identifier: Apache-2.0
// The segments of a drive.
#include "segments.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "profile.hpp"
#include "simulation/quadrature.hpp"

namespace binnacle::vehicle_simulator {

namespace {

constexpr double steepest = 45.0 * degree;
constexpr double shortest = 1e-3;  // s
constexpr double longest = 1e6;    // s

std::string text(double value) {
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.6g", value);
  return buffer.data();
}

/// One element of `segments` with the place where it stands, for messages.
class Element {
 public:
  Element(const ParameterValue& value, std::size_t index, std::int64_t pass)
      : parameters_(value), pointer_("/segments/" + std::to_string(index)), pass_(pass) {}

  const Parameters& parameters() const { return parameters_; }
  const std::string& kind() const { return parameters_.text("do"); }
  bool has(std::string_view name) const { return parameters_.has(name); }
  std::optional<double> number(std::string_view name) const {
    return has(name) ? std::optional(parameters_.number(name)) : std::nullopt;
  }

  [[noreturn]] void refuse(std::string_view member, const std::string& message) const {
    const std::string where = member.empty() ? pointer_ : pointer_ + "/" + std::string(member);
    throw ComponentError(pass_ == 0 ? message : message + " (in pass " + std::to_string(pass_ + 1) + ")", where);
  }

  void allow_only(std::initializer_list<std::string_view> allowed) const {
    for (const std::string_view name : {"duration", "acceleration", "to", "angle", "rate", "slope", "height", "ramp"}) {
      const bool is_allowed = std::find(allowed.begin(), allowed.end(), name) != allowed.end();
      if (has(name) && !is_allowed) refuse(name, "'" + kind() + "' does not take '" + std::string(name) + "'");
    }
  }

  Time duration() const {
    if (!has("duration")) refuse("", "'" + kind() + "' needs 'duration'");
    return parameters_.time("duration");
  }

 private:
  Parameters parameters_;
  std::string pointer_;
  std::int64_t pass_;
};

struct Shape {
  Time duration;
  double ramp;
  double height;
};

Shape shape_over(Time duration, double ramp) { return {duration, Plateau::fitting_ramp(seconds(duration), ramp), 0.0}; }

Shape shape_of_change(Time duration, double change, double ramp) {
  Shape shape = shape_over(duration, ramp);
  shape.height = change / Plateau(seconds(duration), shape.ramp).area();
  return shape;
}

/// How long it takes to change by `change` with a plateau of height `rate` (of the same sign).
Time duration_of_change(double change, double rate, double ramp) {
  const double plateau_only = change / rate;
  return nanoseconds(plateau_only >= ramp ? plateau_only + ramp : 2.0 * plateau_only);
}

/// A manoeuvre given by two of duration, rate of change, and change.
Shape two_of_three(const Element& element, std::string_view rate_name, std::string_view change_name,
                   std::optional<double> change, double ramp) {
  const auto rate = element.number(rate_name);
  const int given = int{element.has("duration")} + int{rate.has_value()} + int{change.has_value()};
  if (given != 2)
    element.refuse("", "'" + element.kind() + "' needs exactly two of 'duration', '" + std::string(rate_name) + "', '" +
                           std::string(change_name) + "'");
  if (!change) {
    Shape shape = shape_over(element.duration(), ramp);
    shape.height = *rate;
    return shape;
  }
  if (!rate) return shape_of_change(element.duration(), *change, ramp);
  if (std::abs(*change) < 1e-9)
    element.refuse(change_name, "there is nothing to change; use 'straight' with a duration");
  if (*rate == 0.0 || (*rate > 0.0) != (*change > 0.0))
    element.refuse(rate_name, "must be " + std::string(*change > 0.0 ? "positive" : "negative") + " to change by " +
                                  text(*change));
  if (!(*change / *rate <= longest)) element.refuse(rate_name, "is so small that it takes more than 1e6 s");
  if (!(*change / *rate >= shortest)) element.refuse(rate_name, "is so large that it takes less than 1 ms");
  return shape_of_change(duration_of_change(*change, *rate, ramp), *change, ramp);
}

double height_gain(double speed, double slope, const Shape& shape) {
  const auto rise = [&](double tau) { return std::sin(slope * SmoothStep::value(tau)); };
  const double plateau = seconds(shape.duration) - 2.0 * shape.ramp;
  return speed * (2.0 * shape.ramp * simulation::gauss_legendre(0.0, 1.0, rise) + plateau * std::sin(slope));
}

double slope_for(const Element& element, double height, double speed, const Shape& shape) {
  const double most = height_gain(speed, steepest, shape);
  if (std::abs(height) > most)
    element.refuse("height", "cannot be reached within " + text(seconds(shape.duration)) + " s at " + text(speed) +
                                 " m/s; " + text(most) + " m would be a slope of 45 deg");
  double low = -steepest, high = steepest;  // the gain grows with the slope
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (low + high);
    (height_gain(speed, middle, shape) < height ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Segment with_shape(Segment at_begin, const Shape& shape) {
  at_begin.duration = shape.duration;
  at_begin.ramp = shape.ramp;
  return at_begin;
}

Segment steady(const Element& element, Segment segment, double ramp) {
  element.allow_only({"duration", "ramp"});
  if (element.kind() == "still" && segment.speed != 0.0)
    element.refuse("do", "the vehicle moves at " + text(segment.speed) + " m/s here; brake to 0 before 'still'");
  return with_shape(segment, shape_over(element.duration(), ramp));
}

Segment accelerated(const Element& element, Segment segment, double ramp) {
  element.allow_only({"duration", "acceleration", "to", "ramp"});
  const auto to = element.number("to");
  std::optional<double> change;
  if (to) change = *to - segment.speed;
  const Shape shape = two_of_three(element, "acceleration", "to", change, ramp);
  segment = with_shape(segment, shape);
  segment.acceleration = shape.height;
  if (segment.end_speed() < 0.0)
    element.refuse(element.has("acceleration") ? "acceleration" : "to", "brakes from " + text(segment.speed) +
                                                                            " m/s to " + text(segment.end_speed()) +
                                                                            " m/s; the speed must not fall below zero");
  return segment;
}

Segment turned(const Element& element, Segment segment, double ramp) {
  element.allow_only({"duration", "angle", "rate", "ramp"});
  if (segment.speed == 0.0) element.refuse("do", "the vehicle stands still here; accelerate before 'turn'");
  const Shape shape = two_of_three(element, "rate", "angle", element.number("angle"), ramp);
  segment = with_shape(segment, shape);
  segment.turn_rate = shape.height;
  return segment;
}

Segment climbed(const Element& element, Segment segment, double ramp) {
  element.allow_only({"duration", "slope", "height", "ramp"});
  if (segment.speed == 0.0) element.refuse("do", "the vehicle stands still here; accelerate before 'climb'");
  if (element.has("slope") == element.has("height"))
    element.refuse("", "'climb' needs exactly one of 'slope', 'height'");
  const Shape shape = shape_over(element.duration(), ramp);
  segment = with_shape(segment, shape);
  segment.slope = element.has("slope") ? *element.number("slope")
                                       : slope_for(element, *element.number("height"), segment.speed, shape);
  return segment;
}

Segment resolved(const Element& element, const Segment& at_begin, double default_ramp) {
  const double ramp = element.has("ramp") ? seconds(element.parameters().time("ramp")) : default_ramp;
  if (element.kind() == "accelerate") return accelerated(element, at_begin, ramp);
  if (element.kind() == "turn") return turned(element, at_begin, ramp);
  if (element.kind() == "climb") return climbed(element, at_begin, ramp);
  return steady(element, at_begin, ramp);
}

}  // namespace

double Segment::end_speed() const {
  const double end = speed + acceleration * Plateau(seconds(duration), ramp).area();
  return std::abs(end) < 1e-9 ? 0.0 : end;  // braking to a stop ends in a stop
}

double Segment::end_heading() const { return heading + turn_rate * Plateau(seconds(duration), ramp).area(); }

std::vector<Segment> read_segments(const Parameters& parameters) {
  const auto& elements = parameters.list("segments");
  if (elements.empty()) throw ComponentError("needs at least one segment", "/segments");
  const double ramp = seconds(parameters.time("ramp"));
  const Parameters start = parameters.object("start");

  std::vector<Segment> segments;
  Segment next;
  next.speed = start.number("speed");
  next.heading = start.number("heading");
  for (std::int64_t pass = 0; pass < parameters.integer("repeat"); ++pass) {
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const Segment& last = segments.emplace_back(resolved(Element(elements[i], i, pass), next, ramp));
      next.begin = last.begin + last.duration;
      next.speed = last.end_speed();
      next.heading = last.end_heading();
    }
  }
  return segments;
}

std::vector<ParameterSpec> segment_members() {
  using namespace parameter;
  return {
      choice("do", {"still", "straight", "accelerate", "turn", "climb"})
          .required()
          .about(
              "still: stand still; straight: keep speed and heading; the others change one of speed, heading, height"),
      time("duration")
          .at_least(shortest)
          .at_most(longest)
          .about("duration; for accelerate and turn it may follow from the other two keys"),
      number("acceleration", "m/s^2")
          .about("accelerate: acceleration along the path between the ramps, negative to brake"),
      number("to", "m/s").at_least(0).about("accelerate: speed at the end"),
      number("angle", "rad").about("turn: change of heading, positive to the right"),
      number("rate", "rad/s").about("turn: rate between the ramps, positive to the right"),
      number("slope", "rad")
          .at_least(-steepest)
          .at_most(steepest)
          .about("climb: slope between the ramps, uphill positive"),
      number("height", "m").about("climb: height gained over the segment, which begins and ends level"),
      time("ramp").at_least(0.01).about(
          "duration of each of the two ramps of this segment, instead of the common 'ramp'"),
  };
}

}  // namespace binnacle::vehicle_simulator
