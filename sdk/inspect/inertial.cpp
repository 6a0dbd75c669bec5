// SPDX-License-Identifier: Apache-2.0
// Units of an inertial sensor: specific force by gravity, rates by turning; rates or increments.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "questions.hpp"
#include "statistics.hpp"

namespace binnacle::inspect {

namespace {

struct Candidate {
  const char* unit;
  const char* kind;
  double factor;  // number of the file · factor = SI rate
};

/// The nearest by ratio, if it is within `most` of it and no other is.
const Candidate* nearest(const std::vector<Candidate>& all, double factor, double most) {
  const Candidate* best = nullptr;
  double distance = most;
  for (const Candidate& each : all)
    if (const double d = std::abs(std::log(factor / each.factor)); d < distance) {
      best = &each;
      distance = d;
    }
  return best;
}

void report_unit(const Channel& channel, const char* kind, const std::vector<std::string>& fields,
                 const Candidate& found_unit, double stated, const std::string& evidence, double confidence,
                 Findings& findings) {
  const Field& field = *channel.find(fields.front());
  const bool differs = std::abs(std::log(stated)) > 0.05;
  Finding found;
  found.kind = kind;
  found.channel = channel.name;
  found.field = fields[0] + ", " + fields[1] + ", " + fields[2];
  found.value = found_unit.factor;
  found.unit = found_unit.unit;
  found.confidence = confidence;
  found.severity = differs && !field.is_guessed ? Severity::warning : Severity::finding;
  const std::string says = field.is_guessed ? "guessed" : "stated";
  found.text = differs ? fmt::format("numbers are in {}{}, not {} as {}", found_unit.unit,
                                     found_unit.kind == std::string("increment") ? " per sample (increments)" : "",
                                     field.unit, says)
                       : fmt::format("numbers are in {}, as {}", field.unit, says);
  found.evidence = evidence;
  if (differs) found.meaning = column_patch(channel, fields, {{"unit", found_unit.unit}, {"kind", found_unit.kind}});
  findings.push_back(std::move(found));
}

}  // namespace

double ask_force_unit(const Channel& channel, Inertial& inertial, Findings& findings) {
  std::vector<double> lengths;
  for (const auto& f : inertial.f) lengths.push_back(f.norm());
  const double length = median(lengths);
  const double step = inertial.step;
  const double stated = channel.find("fx")->scale;
  const bool is_increment = channel.find("fx")->kind == FieldKind::increment;
  // Numbers of the file: the length in the stated unit's SI over its scale.
  const double number = length / stated * (is_increment ? step : 1);
  const std::vector<Candidate> all{{"m/s^2", "rate", 1},
                                   {"g", "rate", 9.80665},
                                   {"mg", "rate", 9.80665e-3},
                                   {"mm/s^2", "rate", 1e-3},
                                   {"ug", "rate", 9.80665e-6},
                                   {"m/s", "increment", 1 / step},
                                   {"g*s", "increment", 9.80665 / step}};
  const double per_number = 9.80665 / number;
  const Candidate* const best = nearest(all, per_number, 0.15);
  if (!best) {
    Finding found;
    found.kind = "force_unit";
    found.channel = channel.name;
    found.field = "fx, fy, fz";
    found.value = per_number;
    found.unit = "m/s^2";
    found.severity = Severity::unknown;
    found.text =
        fmt::format("the length of specific force, {} in the file, is gravity in no unit known here", figure(number));
    found.evidence = "median length over the record";
    findings.push_back(std::move(found));
    return 1;
  }
  const double claimed = stated / (is_increment ? step : 1);
  const double factor = best->factor / claimed;
  report_unit(channel, "force_unit", {"fx", "fy", "fz"}, *best, factor,
              fmt::format("median length {} in the file, {} m/s^2", figure(number), figure(number * best->factor)),
              0.99, findings);
  if (std::abs(std::log(factor)) > 0.05)
    for (auto& f : inertial.f) f *= factor;
  return factor;
}

double ask_rate_unit(const Channel& channel, Inertial& inertial, const Turning& turning, Findings& findings) {
  const Field& field = *channel.find("wx");
  double size = turning.axis.norm();
  double error = turning.axis.cwiseProduct(turning.axis_error).norm() / std::max(size * size, 1e-300);
  if (!turning.is_known || error > 0.15) {
    Finding found;
    found.kind = "rate_unit";
    found.channel = channel.name;
    found.field = "wx, wy, wz";
    found.severity = Severity::unknown;
    found.text = fmt::format("nothing here shows the unit of the rates; taken as {} ({})",
                             field.unit.empty() ? "rad/s" : field.unit, field.is_guessed ? "guessed" : "stated");
    found.evidence =
        turning.used == 0 ? "no velocities to compare with" : "course rates do not follow the angular rates";
    findings.push_back(std::move(found));
    return 1;
  }
  const double step = inertial.step, deg = 0.017453292519943295;
  const std::vector<Candidate> all{{"rad/s", "rate", 1},
                                   {"deg/s", "rate", deg},
                                   {"mdeg/s", "rate", deg * 1e-3},
                                   {"deg/h", "rate", deg / 3600},
                                   {"mrad/s", "rate", 1e-3},
                                   {"rad", "increment", 1 / step},
                                   {"deg", "increment", deg / step}};
  const double claimed = field.scale / (field.kind == FieldKind::increment ? step : 1);
  const Candidate* best = nearest(all, claimed * size, 0.15);
  if (!best && turning.along_gravity > 0) {
    size = turning.along_gravity;
    error = turning.along_gravity_error / size;
    best = nearest(all, claimed * size, 0.15);
  }
  const std::string evidence =
      fmt::format("course rate is {} +- {} times the stated rate about the vertical, over {} intervals", figure(size),
                  figure(error * size), turning.used);
  if (!best) {
    Finding found;
    found.kind = "rate_unit";
    found.channel = channel.name;
    found.field = "wx, wy, wz";
    found.value = size;
    found.severity = Severity::warning;
    found.text = fmt::format("rates are {} times too {}: no unit known here is that",
                             figure(size > 1 ? size : 1 / size), size > 1 ? "small" : "large");
    found.evidence = evidence;
    findings.push_back(std::move(found));
    return 1;
  }
  const double factor = best->factor / claimed;
  report_unit(channel, "rate_unit", {"wx", "wy", "wz"}, *best, factor, evidence, 0.999, findings);
  if (std::abs(std::log(factor)) > 0.05)
    for (auto& w : inertial.w) w *= factor;
  return factor;
}

}  // namespace binnacle::inspect
