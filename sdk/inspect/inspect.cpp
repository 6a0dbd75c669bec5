// SPDX-License-Identifier: Apache-2.0
// All questions in the order in which one answer needs another.
#include "inspect/inspect.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "questions.hpp"
#include "statistics.hpp"

namespace binnacle::inspect {

std::string figure(double value) {
  if (!std::isfinite(value)) return "-";
  return fmt::format("{:.4g}", value);
}

Json source_patch(const Channel& channel, const Json& of_source) {
  // Readers of receivers have none of the keys of a text file.
  if (!channel.type.empty() && channel.type != "csv") return nullptr;
  return {{"sources", {{channel.name, of_source}}}};
}

Json column_patch(const Channel& channel, const std::vector<std::string>& fields, const Json& what) {
  Json columns = Json::object();
  for (const auto& field : fields) columns[field] = what;
  return source_patch(channel, {{"columns", columns}});
}

namespace {

void say_unknown(const Channel& channel, const char* kind, std::string text, Findings& findings) {
  Finding found;
  found.kind = kind;
  found.channel = channel.name;
  found.severity = Severity::unknown;
  found.text = std::move(text);
  findings.push_back(std::move(found));
}

/// What no question below is about.
void ask_meaning(const Channel& channel, Findings& findings) {
  if (channel.has_rows)
    say_unknown(channel, "rows", channel.name + ": a row for each satellite or anchor: not inspected", findings);
  else if (std::ranges::all_of(channel.fields, [](const Field& field) { return field.unit.empty(); }))
    say_unknown(channel, "fields",
                channel.name +
                    ": no column has a known name (wx, gyro_x, lat, vel_n …): only numbers and labels are inspected, "
                    "not their meaning",
                findings);
  else if (channel.is_inertial() && channel.is_fix())
    say_unknown(channel, "fields",
                channel.name +
                    ": inertial samples and fixes in one channel are not compared with each other; with the fixes "
                    "in a file of their own, at their own rate, they are",
                findings);
}

/// Labels that no number of seconds can be are left where they are; the questions skip them.
void ask_one(Channel& channel, Findings& findings) {
  if (!channel.fault.empty()) {
    Finding found;
    found.kind = "unreadable";
    found.channel = channel.name;
    found.severity = Severity::warning;
    found.text = channel.fault;
    found.evidence = "what the source reports";
    findings.push_back(std::move(found));
  }
  ask_meaning(channel, findings);
  if (channel.t.size() < 10 || channel.has_rows) return;
  if (const double factor = label_factor(channel, findings); factor != 1) {
    channel.first_label *= factor;
    for (double& label : channel.t) label *= factor;
  }
  ask_stamps(channel, findings);
  ask_fields(channel, findings);
  for (const Field& field : channel.fields)
    if (field.is_guessed && !field.unit.empty()) {
      Finding found;
      found.kind = "guessed_unit";
      found.channel = channel.name;
      found.field = field.name;
      found.text = fmt::format("column '{}' has no unit: {} is guessed", field.column, field.unit);
      found.evidence = "its name, or its values";
      found.confidence = 0.5;
      findings.push_back(std::move(found));
    }
}

struct Sensor {
  const Channel* channel;
  Inertial inertial;
};

/// Bias of the rates: at rest; else their mean less what turning explains.
Vector3d bias_of(const Inertial& inertial, const RestFigures& rest, const Turning& turning) {
  if (rest.seconds > 3) return rest.mean_w;
  Vector3d sum = Vector3d::Zero();
  double n = 0;
  for (const auto& w : inertial.w)
    if (w.allFinite()) {
      sum += w;
      ++n;
    }
  Vector3d mean = sum / std::max(1.0, n);
  if (turning.is_known) {
    const Vector3d down = turning.axis.normalized();
    mean += down * (-turning.bias / turning.axis.norm() - down.dot(mean));
  }
  return mean;
}

class Pair {
 public:
  Pair(const Channel& imu, Inertial& inertial, const Channel& gnss, Fixes fixes, VelocityRelation relation,
       Inspection& inspection)
      : imu_(imu),
        inertial_(inertial),
        gnss_(gnss),
        fixes_(std::move(fixes)),
        relation_(relation),
        inspection_(inspection) {}

  void ask() {
    Findings& findings = inspection_.findings;
    const double difference = gnss_.first_label - imu_.first_label;
    const auto coarse = ask_clocks(imu_, gnss_, inertial_, fixes_, difference, findings, inspection_.plots);
    if (!coarse) {
      say("delay",
          "the turns do not determine the relation of the clocks: axes, delay and mounting are not determined");
      ask_rate_unit(imu_, inertial_, {}, findings);
      rest_ = find_rest(inertial_);
      ask_rest(imu_, inertial_, rest_, findings);
      if (relation_.is_mirrored) report_mirrored(gnss_, relation_.axis, false, false, findings);
      decide_down(0, Vector3d::Zero(), false);
      return;
    }
    Vector3d up = Vector3d::Zero();
    for (const auto& f : inertial_.f)
      if (f.allFinite()) up += f;
    const Turning turning = turning_at(Integral(inertial_.t, inertial_.w, inertial_.step), fixes_, *coarse, up);
    const double factor = ask_rate_unit(imu_, inertial_, turning, findings);
    rest_ = find_rest(inertial_, &fixes_, *coarse);
    ask_rest(imu_, inertial_, rest_, findings);
    Turning scaled = turning;
    scaled.axis /= factor;
    ask_axes_and_on(*coarse, bias_of(inertial_, rest_, scaled), difference);
  }

  /// With the velocities' signs as they were found to be.
  const Fixes& fixes() const { return fixes_; }

 private:
  void say(const char* kind, const std::string& text) {
    Finding found;
    found.kind = kind;
    found.channel = imu_.name + ", " + gnss_.name;
    found.severity = Severity::unknown;
    found.text = text;
    inspection_.findings.push_back(std::move(found));
  }

  /// A mirrored world of velocities looks as left-handed axes of the sensor: with the velocity's sign changed it does not.
  Axes decide_mirror(double delay, const Vector3d& bias) {
    if (!relation_.is_mirrored) return ask_axes(imu_, inertial_, fixes_, delay, bias, &inspection_.findings);
    const Axes as_is = ask_axes(imu_, inertial_, fixes_, delay, bias, nullptr);
    Fixes turned = fixes_;
    for (auto& v : turned.v) v[relation_.axis] *= -1;
    const Axes other = ask_axes(imu_, inertial_, turned, delay, bias, nullptr);
    // That sign is right with which the sensor's axes are as they should be.
    const auto fits = [](const Axes& axes) {
      return axes.is_known && axes.force.isIdentity() && axes.rate.isIdentity();
    };
    const bool velocity = fits(other) && !fits(as_is);
    report_mirrored(gnss_, relation_.axis, fits(other) != fits(as_is), velocity, inspection_.findings);
    if (velocity) fixes_ = std::move(turned);
    return ask_axes(imu_, inertial_, fixes_, delay, bias, &inspection_.findings);
  }

  void decide_down(double delay, const Vector3d& bias, bool is_known) {
    if (!relation_.is_upside_down) return;
    const int sign = is_known ? sign_of_down(inertial_, fixes_, delay, bias) : 0;
    report_upside_down(gnss_, relation_.vertical_slope, sign != 0, sign < 0, inspection_.findings);
    if (sign < 0)
      for (auto& v : fixes_.v) v[2] = -v[2];
  }

  void ask_axes_and_on(double coarse, const Vector3d& bias, double difference) {
    const Axes axes = decide_mirror(coarse, bias);
    for (auto& w : inertial_.w) w = axes.rate * w;
    for (auto& f : inertial_.f) f = axes.force * f;
    const Vector3d true_bias = axes.rate * bias;
    rest_.mean_f = axes.force * rest_.mean_f;
    decide_down(coarse, true_bias, axes.is_known);
    const double delay = ask_delay(imu_, gnss_, inertial_, fixes_, coarse, true_bias, difference, inspection_.findings);
    inspection_.delay = delay + difference;
    ask_fix_noise(gnss_, fixes_, delay, rest_, inspection_.findings);
    if (axes.is_ruled_out) return;
    Vector3d lever_arm = Vector3d::Zero();
    LeverArm antenna;
    inspection_.mounting =
        ask_mounting(imu_, gnss_, inertial_, fixes_, delay, true_bias, rest_, lever_arm, antenna, inspection_.findings);
    if (antenna.windows > 0 && axes.force.isIdentity() && axes.rate.isIdentity())
      inspection_.lever_arm = SeenLeverArm{imu_.name, gnss_.name, antenna.value, antenna.covariance};
    if (inspection_.mounting) inspection_.start = start_of(inertial_, fixes_, delay, rest_, *inspection_.mounting);
    ask_velocity_faults(gnss_, inertial_, fixes_, delay, true_bias, lever_arm, inspection_.findings, inspection_.plots);
  }

  const Channel& imu_;
  Inertial& inertial_;
  const Channel& gnss_;
  Fixes fixes_;
  VelocityRelation relation_;
  Inspection& inspection_;
  RestFigures rest_;
};

}  // namespace

void sort(Findings& findings) {
  std::ranges::stable_sort(findings, {}, [](const Finding& found) {
    return found.severity == Severity::warning ? 0 : found.severity == Severity::finding ? 1 : 2;
  });
}

Inspection inspect(std::vector<Channel> channels) {
  Inspection inspection;
  inspection.channels = std::move(channels);
  Findings& findings = inspection.findings;
  for (Channel& channel : inspection.channels) ask_one(channel, findings);
  const Channel* gnss = nullptr;
  Fixes fixes;
  VelocityRelation relation;
  for (const Channel& channel : inspection.channels) {
    if (!channel.is_fix() || channel.is_inertial() || channel.t.size() < 10) continue;
    Fixes its = fixes_of(channel);
    const VelocityRelation its_relation = ask_velocity(channel, its, findings);
    ask_frozen(channel, its, findings);
    ask_deviations(channel, its, findings);
    if (gnss || !its.has_velocity || channel.is_reference()) {
      ask_heading(channel, its, findings);
      continue;
    }
    gnss = &channel;
    fixes = std::move(its);
    relation = its_relation;
  }
  bool has_heading = false;
  for (const Channel& channel : inspection.channels) {
    if (!channel.is_inertial() || channel.t.size() < 10) continue;
    // A triad of which one field stands still shows neither its unit nor its axes.
    if (const auto dead = std::ranges::find_if(findings,
                                               [&](const Finding& each) {
                                                 return each.kind == "constant" && each.channel == channel.name;
                                               });
        dead != findings.end()) {
      Finding found;
      found.kind = "axes";
      found.channel = channel.name;
      found.severity = Severity::unknown;
      found.text = dead->field + " is constant: units, axes, delay and mounting are not determined";
      findings.push_back(std::move(found));
      continue;
    }
    Inertial inertial = inertial_of(channel);
    ask_force_unit(channel, inertial, findings);
    if (gnss) {
      Pair pair(channel, inertial, *gnss, fixes, relation, inspection);
      pair.ask();
      if (!has_heading) ask_heading(*gnss, pair.fixes(), findings);
      has_heading = true;
    } else {
      ask_rate_unit(channel, inertial, {}, findings);
      ask_rest(channel, inertial, find_rest(inertial), findings);
    }
    ask_vibration(channel, inertial, find_rest(inertial), findings);
  }
  if (gnss && !has_heading) {
    if (relation.is_mirrored) report_mirrored(*gnss, relation.axis, false, false, findings);
    if (relation.is_upside_down) report_upside_down(*gnss, relation.vertical_slope, false, false, findings);
    if (!relation.is_mirrored) ask_heading(*gnss, fixes, findings);
  }
  sort(findings);
  return inspection;
}

}  // namespace binnacle::inspect
