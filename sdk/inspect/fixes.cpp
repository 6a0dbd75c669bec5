// SPDX-License-Identifier: Apache-2.0
// Fixes by themselves: velocity against differences of position, fields that stand still, standard deviations against scatter.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Core>

#include "binnacle/geodesy.hpp"
#include "questions.hpp"
#include "statistics.hpp"

namespace binnacle::inspect {

namespace {

constexpr double degree = 0.017453292519943295;

Finding finding(const Channel& channel, std::string kind, std::string field, Severity severity) {
  Finding found;
  found.kind = std::move(kind);
  found.channel = channel.name;
  found.field = std::move(field);
  found.severity = severity;
  return found;
}

/// Displacements [m] by position and by velocity, over intervals of at least `length` s that do not overlap.
struct Displacements {
  std::vector<Vector3d> position, velocity;
  std::vector<double> from, to;
};

Vector3d between(const Vector3d& a, const Vector3d& b) {
  const double lat = std::clamp(a[0], -1.57, 1.57);
  const auto radii = geodesy::radii(std::sin(lat), std::cos(lat));
  return {(b[0] - a[0]) * radii.meridian,
          std::remainder(b[1] - a[1], 6.283185307179586) * radii.transverse * std::cos(lat),
          std::isfinite(b[2] - a[2]) ? a[2] - b[2] : 0};
}

Displacements displacements(const Fixes& fixes, double length) {
  Displacements all;
  std::size_t first = 0;
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 1; i < fixes.t.size(); ++i) {
    const double dt = fixes.t[i] - fixes.t[i - 1];
    if (dt > 3 * fixes.step || !fixes.v[i].allFinite() || !fixes.v[i - 1].allFinite()) {
      first = i;
      sum.setZero();
      continue;
    }
    sum += 0.5 * dt * (fixes.v[i] + fixes.v[i - 1]);
    if (fixes.t[i] - fixes.t[first] < length - 1e-6) continue;
    const Vector3d moved = between(fixes.p[first], fixes.p[i]);
    if (std::isfinite(moved[0]) && std::isfinite(moved[1])) {
      all.position.push_back(moved);
      all.velocity.push_back(sum);
      all.from.push_back(fixes.t[first]);
      all.to.push_back(fixes.t[i]);
    }
    first = i;
    sum.setZero();
  }
  return all;
}

struct Unit2 {
  const char* name;
  double scale;
  double times = 1;  // of the unit: what it is called by in a config
};
constexpr Unit2 speed_units[] = {{"m/s", 1},       {"km/h", 1 / 3.6}, {"kn", 0.514444},
                                 {"ft/s", 0.3048}, {"cm/s", 1e-2},    {"mm/s", 1e-3}};
constexpr Unit2 angle_units[] = {
    {"deg", degree}, {"rad", 1}, {"arcmin", degree / 60}, {"arcsec", degree / 3600}, {"deg", degree * 1e-7, 1e-7}};
constexpr Unit2 length_units[] = {{"m", 1}, {"ft", 0.3048}, {"cm", 1e-2}, {"mm", 1e-3}, {"km", 1e3}};

template <std::size_t N>
const Unit2* nearest(const Unit2 (&all)[N], double scale, double most = 0.06) {
  for (const Unit2& each : all)
    if (std::abs(std::log(scale / each.scale)) < most) return &each;
  return nullptr;
}

void report_unit(const Channel& channel, const char* kind, const std::vector<std::string>& fields, const Unit2& unit,
                 double factor, const std::string& evidence, Findings& findings) {
  Finding found = finding(channel, kind, "", Severity::warning);
  for (const auto& field : fields) found.field += (found.field.empty() ? "" : ", ") + field;
  const Field& field = *channel.find(fields.front());
  found.value = factor;
  found.text = fmt::format("numbers are in {}{}, not {} as {}", unit.times == 1 ? "" : figure(unit.times) + " ",
                           unit.name, field.unit, field.is_guessed ? "guessed" : "stated");
  found.unit = unit.name;
  found.evidence = evidence;
  found.confidence = 0.99;
  Json what = {{"unit", unit.name}};
  if (unit.times != 1) what["scale"] = unit.times;
  found.meaning = column_patch(channel, fields, what);
  findings.push_back(std::move(found));
}

std::vector<std::string> there(const Channel& channel, std::initializer_list<const char*> names) {
  std::vector<std::string> list;
  for (const char* name : names)
    if (channel.find(name)) list.emplace_back(name);
  return list;
}

/// displacement by position = A · displacement by velocity, horizontally.
struct Horizontal {
  Eigen::Matrix2d A, error;
  std::size_t used = 0;
};

Horizontal relate(const Displacements& all) {
  const auto n = static_cast<Eigen::Index>(all.position.size());
  Eigen::MatrixXd X(n, 2);
  Eigen::VectorXd north(n), east(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    X.row(i) = all.velocity[k].head<2>().transpose();
    north[i] = all.position[k][0];
    east[i] = all.position[k][1];
  }
  const LinearFit a = robust_fit(X, north), b = robust_fit(X, east);
  Horizontal fit;
  fit.used = a.used;
  fit.A << a.beta.transpose(), b.beta.transpose();
  fit.error << a.standard_error.transpose(), b.standard_error.transpose();
  return fit;
}

/// Exchanged: of the position, the latitude in the scale gives itself away.
void report_exchange(const Channel& channel, const Horizontal& fit, Fixes& fixes, const std::string& evidence,
                     Findings& findings) {
  const bool is_velocity = std::abs(std::abs(fit.A(0, 1)) - 1) < 0.1 && std::abs(std::abs(fit.A(1, 0)) - 1) < 0.1;
  const char *const x = is_velocity ? "vn" : "lat", *const y = is_velocity ? "ve" : "lon";
  Finding found = finding(channel, is_velocity ? "velocity_exchanged" : "position_exchanged",
                          fmt::format("{}, {}", x, y), Severity::warning);
  found.value = fit.A(0, 1);
  found.text = fmt::format("{} and {} are exchanged", x, y);
  found.evidence = evidence;
  found.confidence = 0.99;
  found.meaning = source_patch(
      channel, {{"columns", {{x, {{"column", channel.find(y)->column}}}, {y, {{"column", channel.find(x)->column}}}}}});
  findings.push_back(std::move(found));
  if (is_velocity)
    for (auto& v : fixes.v) std::swap(v[0], v[1]);
  else
    for (auto& p : fixes.p) std::swap(p[0], p[1]);
}

void ask_vertical(const Channel& channel, Fixes& fixes, VelocityRelation& relation, Findings& findings) {
  if (!fixes.has_down || !fixes.has_height) return;
  const Displacements all = displacements(fixes, 10);
  const auto n = static_cast<Eigen::Index>(all.position.size());
  Eigen::MatrixXd X(n, 1);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    X(i, 0) = all.velocity[static_cast<std::size_t>(i)][2];
    y[i] = all.position[static_cast<std::size_t>(i)][2];
  }
  const LinearFit fit = robust_fit(X, y);
  const double slope = fit.beta[0], error = fit.standard_error[0];
  const std::string evidence =
      fmt::format("heights sink by {} +- {} times the integral of vd, over {} intervals of 10 s", figure(slope),
                  figure(error), n);
  if (fit.used == 0 || std::abs(slope) < 6 * error || error > 0.1 * std::max(1.0, std::abs(slope))) {
    Finding found = finding(channel, "vertical", "vd, height", Severity::unknown);
    found.value = slope;
    found.text = "too little climbing to check the sign of vd and the unit of the height: see the receiver's manual";
    found.evidence = evidence;
    findings.push_back(std::move(found));
    return;
  }
  if (slope < 0) {
    relation.is_upside_down = true;
    relation.vertical_slope = slope;
    for (auto& p : fixes.p) p[2] = -p[2];
  }
  const double factor = std::abs(slope);
  if (std::abs(factor - 1) > std::max(0.2, 5 * error)) {
    const double stated = channel.find("height")->scale;
    if (const Unit2* unit = nearest(length_units, stated / factor, 0.25)) {
      report_unit(channel, "height_unit", {"height"}, *unit, unit->scale / stated, evidence, findings);
      for (auto& p : fixes.p) p[2] *= unit->scale / stated;
    }
  }
}

}  // namespace

namespace {

void report_agreement(const Channel& channel, double scale, const std::string& evidence, Findings& findings) {
  Finding found = finding(channel, "velocity", "vn, ve", Severity::finding);
  found.value = scale;
  found.text = "velocities lead where positions go";
  found.evidence = evidence;
  findings.push_back(std::move(found));
}

/// Latitudes beyond the poles: of the units in which none is, that by which positions move as velocities lead.
void ask_range(const Channel& channel, Fixes& fixes, Findings& findings) {
  std::vector<double> lat;
  for (const auto& p : fixes.p) lat.push_back(std::abs(p[0]));
  const double stated = channel.find("lat")->scale;
  // Exchanged with a longitude, it may be up to 180 deg.
  if (!(quantile(lat, 0.5) > 3.15)) return;
  for (const Unit2& unit : angle_units) {
    Fixes other = fixes;
    for (auto& p : other.p) p.head<2>() *= unit.scale / stated;
    if (quantile(lat, 0.5) * unit.scale / stated > 1.5708) continue;
    const Horizontal fit = relate(displacements(other, 2));
    const double size = fit.A.cwiseAbs().maxCoeff();
    if (fit.used == 0 || fit.error.maxCoeff() > 0.05 * size || std::abs(std::log(size)) > 0.06) continue;
    report_unit(channel, "position_unit", {"lat", "lon"}, unit, unit.scale / stated,
                fmt::format("latitudes of {} {}; in this unit positions move {} times as far as velocities lead",
                            figure(quantile(lat, 0.5) / stated), channel.find("lat")->unit, figure(size)),
                findings);
    fixes = std::move(other);
    return;
  }
}

}  // namespace

VelocityRelation ask_velocity(const Channel& channel, Fixes& fixes, Findings& findings) {
  VelocityRelation relation;
  if (!fixes.has_velocity || !fixes.has_position) return relation;
  ask_range(channel, fixes, findings);
  const Displacements all = displacements(fixes, 2);
  const Horizontal fit = relate(all);
  const std::string evidence = fmt::format(
      "displacement [north, east] is [{} {}; {} {}] (+- {}) times the integral of [vn, ve], over {} intervals of 2 s",
      figure(fit.A(0, 0)), figure(fit.A(0, 1)), figure(fit.A(1, 0)), figure(fit.A(1, 1)), figure(fit.error.maxCoeff()),
      fit.used);
  const double size = fit.A.cwiseAbs().maxCoeff();
  if (fit.used == 0 || fit.error.maxCoeff() > 0.05 * size) {
    Finding found = finding(channel, "velocity", "vn, ve", Severity::unknown);
    found.text = "too little motion to compare velocities with positions";
    found.evidence = evidence;
    findings.push_back(std::move(found));
    return relation;
  }
  if (std::abs(fit.A(0, 1)) + std::abs(fit.A(1, 0)) > 2 * (std::abs(fit.A(0, 0)) + std::abs(fit.A(1, 1)))) {
    report_exchange(channel, fit, fixes, evidence, findings);
    ask_vertical(channel, fixes, relation, findings);
    return relation;
  }
  const double north = fit.A(0, 0), east = fit.A(1, 1);
  const double scale = std::abs(north);
  if (std::abs(std::log(scale)) > 0.1) {
    const Unit2* const speed = nearest(speed_units, channel.find("vn")->scale * scale);
    const Unit2* const angle = nearest(angle_units, channel.find("lat")->scale / scale);
    if (speed) {
      report_unit(channel, "velocity_unit", there(channel, {"vn", "ve", "vd"}), *speed, scale, evidence, findings);
      for (auto& v : fixes.v) v *= scale;
    } else if (angle) {
      report_unit(channel, "position_unit", {"lat", "lon"}, *angle, 1 / scale, evidence, findings);
      for (auto& p : fixes.p) p.head<2>() /= scale;
    } else {
      Finding found = finding(channel, "velocity", "vn, ve", Severity::warning);
      found.value = scale;
      found.text = fmt::format("positions move {} times as far as velocities lead", figure(scale));
      found.evidence = evidence;
      findings.push_back(std::move(found));
    }
  } else if (north > 0 && east > 0) {
    report_agreement(channel, scale, evidence, findings);
  }
  if (north * east < 0) {
    relation.is_mirrored = true;
    relation.axis = north < 0 ? 0 : 1;
    for (auto& p : fixes.p) p[relation.axis] *= -1;
  } else if (north < 0) {
    Finding found = finding(channel, "velocity_sign", "vn, ve", Severity::warning);
    found.value = -1;
    found.text = "velocities point backwards";
    found.evidence = evidence;
    found.meaning = column_patch(channel, {"vn", "ve"}, {{"scale", -1}});
    findings.push_back(std::move(found));
    for (auto& v : fixes.v) v.head<2>() *= -1;
  }
  ask_vertical(channel, fixes, relation, findings);
  return relation;
}

void report_mirrored(const Channel& channel, int axis, bool is_known, bool velocity_is_at_fault, Findings& findings) {
  const char* const velocity = axis == 0 ? "vn" : "ve";
  const char* const position = axis == 0 ? "lat" : "lon";
  Finding found = finding(channel, velocity_is_at_fault ? "velocity_sign" : "position_sign",
                          velocity_is_at_fault ? velocity : position, Severity::warning);
  found.value = -1;
  if (!is_known) {
    found.field = fmt::format("{}, {}", velocity, position);
    found.text =
        fmt::format("{} has the wrong sign against {}; which of the two cannot be told apart here", velocity, position);
  } else {
    found.text = fmt::format("{} has the wrong sign", found.field);
    found.meaning = column_patch(channel, {found.field}, {{"scale", -1}});
  }
  found.evidence = "displacements against the integral of velocity, and the sense of turning of the gyros";
  found.confidence = 0.99;
  findings.push_back(std::move(found));
}

void report_upside_down(const Channel& channel, double slope, bool is_known, bool velocity_is_at_fault,
                        Findings& findings) {
  Finding found = finding(channel,
                          !is_known              ? "vertical_sign"
                          : velocity_is_at_fault ? "down_sign"
                                                 : "height_sign",
                          !is_known              ? "vd, height"
                          : velocity_is_at_fault ? "vd"
                                                 : "height",
                          Severity::warning);
  found.value = slope;
  found.text = !is_known ? "vd is positive upwards, or height has the wrong sign: these data do not show which"
               : velocity_is_at_fault ? "vd is positive upwards"
                                      : "height has the wrong sign";
  found.evidence = fmt::format("heights sink by {} times the integral of vd{}", figure(slope),
                               is_known ? "; the specific force supports one sign of vd" : "");
  found.confidence = 0.99;
  if (is_known) found.meaning = column_patch(channel, {found.field}, {{"scale", -1}});
  findings.push_back(std::move(found));
}

void ask_frozen(const Channel& channel, const Fixes& fixes, Findings& findings) {
  if (!fixes.has_velocity || !fixes.has_position) return;
  const auto runs = [&](auto same, auto moved, const std::string& kind, const std::string& field,
                        const std::string& text) {
    Finding found = finding(channel, kind, field, Severity::warning);
    found.value = 0;
    for (std::size_t i = 0; i < fixes.t.size();) {
      std::size_t end = i + 1;
      while (end < fixes.t.size() && same(end - 1, end)) ++end;
      const double length = fixes.t[end - 1] - fixes.t[i];
      if (end - i >= 4 && moved(i, end - 1) && length > found.value) {
        found.value = length;
        found.from = fixes.t[i];
        found.to = fixes.t[end - 1];
      }
      i = end;
    }
    if (found.value == 0) return;
    found.unit = "s";
    found.text = fmt::format("{} for {} s from {} s", text, figure(found.value), figure(found.from));
    found.evidence = "equal values of successive fixes, at least four, where the other moves by more than 5 m";
    findings.push_back(std::move(found));
  };
  runs([&](std::size_t a, std::size_t b) { return fixes.v[a] == fixes.v[b]; },
       [&](std::size_t a, std::size_t b) {
         // A simulated velocity that stays is the way's own.
         const Vector3d way = between(fixes.p[a], fixes.p[b]), steady = (fixes.t[b] - fixes.t[a]) * fixes.v[a];
         return way.head<2>().norm() > 5 && (way - steady).head<2>().norm() > 1e-3 * way.head<2>().norm();
       },
       "velocity_held", "vn, ve, vd", "the velocity is held while the position moves");
  runs([&](std::size_t a, std::size_t b) { return fixes.p[a].head<2>() == fixes.p[b].head<2>(); },
       [&](std::size_t a, std::size_t b) {
         return (fixes.t[b] - fixes.t[a]) * std::min(fixes.v[a].head<2>().norm(), fixes.v[b].head<2>().norm()) > 5;
       },
       "position_held", "lat, lon", "the position is held while the velocity changes");
  // Jumps: beyond ten times the 99th percentile of what single steps are off by, and 5 m.
  std::vector<double> off{0};
  for (std::size_t i = 1; i < fixes.t.size(); ++i) {
    const Vector3d d =
        between(fixes.p[i - 1], fixes.p[i]) - 0.5 * (fixes.t[i] - fixes.t[i - 1]) * (fixes.v[i] + fixes.v[i - 1]);
    off.push_back(fixes.t[i] - fixes.t[i - 1] < 3 * fixes.step && std::isfinite(d[0] + d[1]) ? d.head<2>().norm() : 0);
  }
  const double limit = std::max(5.0, 10 * quantile(off, 0.99));
  const auto worst = static_cast<std::size_t>(std::ranges::max_element(off) - off.begin());
  if (off[worst] < limit) return;
  Finding found = finding(channel, "position_jump", "lat, lon", Severity::warning);
  found.value = off[worst];
  found.unit = "m";
  found.from = found.to = fixes.t[worst];
  found.text = fmt::format("positions jump {} times, by {} m at {} s, where velocities do not",
                           std::ranges::count_if(off, [&](double d) { return d > limit; }), figure(found.value),
                           figure(found.from));
  found.evidence =
      fmt::format("limit {} m: ten times the 99th percentile of single steps, 5 m at least", figure(limit));
  findings.push_back(std::move(found));
}

namespace {

void judge(const Channel& channel, const char* field, double scatter, Findings& findings) {
  const Field* const stated = channel.find(field);
  if (!stated) return;
  const double sd = median(stated->values);
  if (!(sd > 0) || !(scatter > 0)) return;
  const double ratio = sd / scatter;
  // Errors of fixes are correlated over seconds, so scatter from one fix to the next is less than the deviation: a receiver's own
  // figure is up to some tens of times larger, and hardly smaller at all.
  const bool is_absurd = ratio > 200 || ratio < 0.1;
  Finding found = finding(channel, "deviation", field, is_absurd ? Severity::warning : Severity::finding);
  found.value = ratio;
  found.text =
      fmt::format("stated {} {}, {} times what scatters from fix to fix{}", figure(sd), stated->si, figure(ratio),
                  ratio > 200   ? ": absurdly large; is it in another unit, or a variance?"
                  : ratio < 0.1 ? ": absurdly small; is it in another unit?"
                                : "");
  found.evidence = fmt::format("median of the column against a robust scatter of {} {}", figure(scatter), stated->si);
  found.confidence = 0.9;
  findings.push_back(std::move(found));
}

}  // namespace

void ask_deviations(const Channel& channel, const Fixes& fixes, Findings& findings) {
  std::vector<double> v[3], p[3];
  for (std::size_t i = 2; i < fixes.t.size(); ++i) {
    if (fixes.t[i] - fixes.t[i - 2] > 4 * fixes.step) continue;
    const Vector3d second = fixes.v[i] - 2 * fixes.v[i - 1] + fixes.v[i - 2];
    const Vector3d d =
        between(fixes.p[i - 1], fixes.p[i]) - 0.5 * (fixes.t[i] - fixes.t[i - 1]) * (fixes.v[i] + fixes.v[i - 1]);
    for (int k = 0; k < 3; ++k) {
      if (std::isfinite(second[k])) v[k].push_back(second[k]);
      if (std::isfinite(d[k])) p[k].push_back(d[k]);
    }
  }
  constexpr const char* velocity[] = {"velocity_sd_n", "velocity_sd_e", "velocity_sd_d"};
  constexpr const char* position[] = {"position_sd_n", "position_sd_e", "position_sd_d"};
  for (int k = 0; k < 3; ++k) {
    if (fixes.has_velocity) judge(channel, velocity[k], robust_sigma(v[k]) / std::sqrt(6.0), findings);
    if (fixes.has_velocity && fixes.has_position)
      judge(channel, position[k], robust_sigma(p[k]) / std::sqrt(2.0), findings);
  }
}

namespace {

/// Its part from `first` on, of north, east, down, is what the finding is about.
struct Scatter {
  const char *kind, *what, *fields, *axes, *unit;
  int first, count;
};

/// Root mean squares; only of eight values at least, so that they are known to a quarter.
void report_scatter(const Channel& channel, const Scatter& scatter, const std::vector<Vector3d>& values,
                    Findings& findings) {
  if (values.size() < 8) return;
  Vector3d square = Vector3d::Zero();
  for (const Vector3d& each : values) square += each.cwiseAbs2();
  const Vector3d rms = (square / static_cast<double>(values.size())).cwiseSqrt();
  Finding found = finding(channel, scatter.kind, scatter.fields, Severity::finding);
  std::string figures;
  for (int k = scatter.first; k < scatter.first + scatter.count; ++k) {
    found.value = std::max(found.value, rms[k]);
    figures += (figures.empty() ? "" : ", ") + figure(rms[k]);
  }
  found.unit = scatter.unit;
  found.text = fmt::format("{} by {} {} ({}) at rest; slower errors are not in this", scatter.what, figures,
                           scatter.unit, scatter.axes);
  found.evidence = fmt::format("{} fixes at rest", values.size());
  findings.push_back(std::move(found));
}

}  // namespace

void ask_fix_noise(const Channel& channel, const Fixes& fixes, double delay, const RestFigures& rest,
                   Findings& findings) {
  if (!rest.is_seen) return;
  std::vector<Vector3d> positions, velocities;
  for (const Rest& span : rest.spans) {
    std::vector<Vector3d> its;  // from the first [m]
    const Vector3d* first = nullptr;
    for (std::size_t i = 0; i < fixes.t.size(); ++i) {
      // A second from moving: a rest is known to that.
      if (fixes.t[i] < span.from + delay + 1 || fixes.t[i] > span.to + delay - 1) continue;
      if (fixes.has_velocity && fixes.v[i].allFinite()) velocities.push_back(fixes.v[i]);
      if (!fixes.has_position || !fixes.has_height || !fixes.p[i].allFinite()) continue;
      if (!first) first = &fixes.p[i];
      its.push_back(between(*first, fixes.p[i]));
    }
    if (its.size() < 4) continue;
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& each : its) mean += each;
    mean /= static_cast<double>(its.size());
    const double unbiased = std::sqrt(static_cast<double>(its.size()) / static_cast<double>(its.size() - 1));
    for (const Vector3d& each : its) positions.push_back(unbiased * (each - mean));
  }
  report_scatter(channel, {"position_noise", "positions scatter", "lat, lon", "north, east", "m", 0, 2}, positions,
                 findings);
  report_scatter(channel, {"height_noise", "heights scatter", "height", "down", "m", 2, 1}, positions, findings);
  report_scatter(channel, {"velocity_noise", "velocities scatter", "vn, ve, vd", "north, east, down", "m/s", 0, 3},
                 velocities, findings);
}

}  // namespace binnacle::inspect
