// SPDX-License-Identifier: Apache-2.0
// Allan variances as a table, as JSON and as a picture.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "allan_channel.hpp"
#include "output.hpp"
#include "table.hpp"

namespace binnacle::command {

namespace {

constexpr double most_of_fit = 3;  // chi-square per degree of freedom

using allan::Term;

/// Of a coefficient of a signal in `unit`; "rad/s" and a white term: "rad/sqrt(s)".
std::string unit_of(Term term, const std::string& unit) {
  const bool is_rate = unit.size() > 2 && unit.ends_with("/s");
  const std::string integral = unit == "m/s^2" ? "m/s" : is_rate ? unit.substr(0, unit.size() - 2) : unit + " s";
  switch (term) {
    case Term::quantization: return integral;
    case Term::white: return unit == "m/s^2" || is_rate ? integral + "/sqrt(s)" : unit + " sqrt(s)";
    case Term::flicker: return unit;
    case Term::random_walk: return unit + "/sqrt(s)";
    case Term::ramp: return unit + "/s";
  }
  return unit;
}

/// The usual unit of an inertial sensor, and how many of it one SI unit is; an empty one where there is none.
struct Usual {
  std::string unit;
  double factor = 1;
};
Usual usual_of(Term term, const std::string& unit) {
  constexpr double degree = 180 / std::numbers::pi;
  const bool is_gyro = unit == "rad/s", is_accelerometer = unit == "m/s^2";
  if (!is_gyro && !is_accelerometer) return {};
  switch (term) {
    case Term::quantization: return is_gyro ? Usual{"arcsec", degree * 3600} : Usual{};
    case Term::white: return is_gyro ? Usual{"deg/sqrt(h)", degree * 60} : Usual{"m/s/sqrt(h)", 60};
    case Term::flicker: return is_gyro ? Usual{"deg/h", degree * 3600} : Usual{"mg", 1e3 / 9.80665};
    case Term::random_walk:
      return is_gyro ? Usual{"deg/h/sqrt(h)", degree * 3600 * 60} : Usual{"mg/sqrt(h)", 6e4 / 9.80665};
    case Term::ramp: return is_gyro ? Usual{"deg/h/h", degree * 3600 * 3600} : Usual{"mg/h", 3.6e6 / 9.80665};
  }
  return {};
}

/// What takes it: parameters of models, with their values in SI.
Json parameters_of(const allan::Fit::Estimate& estimate, const std::string& unit) {
  if (estimate.term == Term::white && unit == "rad/s") return {{"phi_error.gyro_noise", estimate.value}};
  if (estimate.term == Term::white && unit == "m/s^2") return {{"phi_error.accel_noise", estimate.value}};
  if (estimate.term == Term::random_walk) return {{"random_walk.q", estimate.value}};
  if (estimate.term != Term::flicker) return nullptr;
  // A Gauss–Markov process has its largest Allan deviation, 0.617 of its sigma, at 1.89 of its correlation time: there it is
  // made to equal the floor.
  const double floor = estimate.value * std::sqrt(2 * std::numbers::ln2 / std::numbers::pi);
  return {{"gauss_markov.sigma", floor / 0.617},
          {"gauss_markov.tau", std::sqrt(estimate.from_tau * estimate.to_tau) / 1.89}};
}

const char* why_absent(Term term, const AllanChannel& channel, const AllanField& field) {
  const double longest = field.points.empty() ? 0 : field.points.back().tau;
  const bool is_slow = term == Term::random_walk || term == Term::ramp || term == Term::flicker;
  return is_slow && longest < 1000 * channel.interval ? "the record is too short" : "not seen";
}

}  // namespace

Json allan_json(const AllanChannel& channel) {
  Json fields = Json::object();
  for (const AllanField& field : channel.fields) {
    Json terms = Json::array(), absent = Json::object(), points = Json::array();
    for (const auto& estimate : field.fit.estimates) {
      Json term{{"term", term_name(estimate.term)},
                {"value", estimate.value},
                {"low", estimate.low},
                {"high", estimate.high},
                {"unit", unit_of(estimate.term, field.unit)},
                {"from_tau_s", estimate.from_tau},
                {"to_tau_s", estimate.to_tau}};
      if (const Json parameters = parameters_of(estimate, field.unit); !parameters.is_null())
        term["parameters"] = parameters;
      terms.push_back(std::move(term));
    }
    for (int t = 0; t < allan::term_count && field.fit.used > 0; ++t)
      if (const double largest = field.fit.largest[static_cast<std::size_t>(t)]; largest > 0)
        absent[allan::term_name(static_cast<Term>(t))] = {{"below", largest},
                                                          {"unit", unit_of(static_cast<Term>(t), field.unit)},
                                                          {"reason", why_absent(static_cast<Term>(t), channel, field)}};
    for (const auto& point : field.points)
      points.push_back({{"tau_s", point.tau}, {"deviation", std::sqrt(point.variance)}, {"differences", point.count}});
    fields[field.name] = {{"unit", field.unit}, {"invalid", field.invalid},           {"terms", terms},
                          {"absent", absent},   {"chi_square", field.fit.chi_square}, {"used", field.fit.used},
                          {"points", points}};
  }
  return {{"channel", channel.name},      {"interval_s", channel.interval},
          {"seconds", channel.seconds},   {"samples", channel.samples},
          {"gaps", channel.gaps},         {"missing_s", channel.missing},
          {"repeated", channel.repeated}, {"fields", fields}};
}

std::string allan_text(const AllanChannel& channel) {
  std::string text = fmt::format("{}: {} samples, one each {} s, over {} s\n", channel.name, channel.samples,
                                 figure(channel.interval), figure(channel.seconds));
  if (channel.gaps > 0)
    text += fmt::format("  {} of together {} s; averages do not span them\n",
                        counted(static_cast<std::size_t>(channel.gaps), "gap"), figure(channel.missing));
  if (channel.repeated > 0)
    text += fmt::format(
        "  {} skipped, because they are less than half an interval after the previous one, or not after it\n",
        counted(static_cast<std::size_t>(channel.repeated), "sample"));
  Table table("llrrrlrl");
  table.row({"field", "term", "value", "95 % from", "to", "unit", "", "usual unit"});
  Table absent("llrl");
  for (const AllanField& field : channel.fields) {
    if (field.invalid > 0)
      text += fmt::format("  {}: {} not finite; averages do not span them\n", field.name,
                          counted(static_cast<std::size_t>(field.invalid), "value"));
    if (field.fit.used == 0) text += fmt::format("  {}: the record is too short, or constant\n", field.name);
    std::string name = field.name;
    const bool fits = field.fit.chi_square <= most_of_fit;
    for (const auto& estimate : field.fit.estimates) {
      const Usual usual = usual_of(estimate.term, field.unit);
      table.row({std::exchange(name, ""), term_name(estimate.term), figure(estimate.value),
                 fits ? figure(estimate.low) : "-", fits ? figure(estimate.high) : "-",
                 unit_of(estimate.term, field.unit), usual.unit.empty() ? "" : figure(estimate.value * usual.factor),
                 usual.unit});
    }
    if (!fits)
      text += fmt::format(
          "  {}: no sum of these terms fits (chi-square {} per degree of freedom): the sensor moves, or drifts in "
          "another way; values have no limits, and missing terms no bound\n",
          field.name, figure(field.fit.chi_square));
    name = field.name;
    for (int t = 0; fits && t < allan::term_count && field.fit.used > 0; ++t) {
      const auto term = static_cast<Term>(t);
      if (const double largest = field.fit.largest[static_cast<std::size_t>(t)]; largest > 0)
        absent.row({std::exchange(name, ""), term_name(term), "below " + figure(largest),
                    unit_of(term, field.unit) + ", " + why_absent(term, channel, field)});
    }
  }
  return text + "\n" + table.text() + (absent.empty() ? "" : "\nNot determined by this record:\n" + absent.text());
}

namespace {

constexpr double width = 720, height = 420, left = 80, bottom = 50, top = 30, right = 130;
const std::vector<std::string> colours = {"#1b6ca8", "#c1440e", "#2f7d32", "#7b3fa0", "#8a6d00", "#444444"};

/// One panel: the fields of one unit.
struct Panel {
  double low_tau = 1e300, high_tau = 0, low = 1e300, high = 0;
  std::vector<const AllanField*> fields;

  void add(const AllanField& field) {
    fields.push_back(&field);
    for (const auto& point : field.points) {
      if (!(point.variance > 0)) continue;
      low_tau = std::min(low_tau, point.tau);
      high_tau = std::max(high_tau, point.tau);
      low = std::min(low, std::sqrt(point.variance));
      high = std::max(high, std::sqrt(point.variance));
    }
  }
  double x(double tau) const {
    return left + (width - left - right) * (std::log10(tau) - first(low_tau)) / (last(high_tau) - first(low_tau));
  }
  double y(double deviation) const {
    return height - bottom - (height - bottom - top) * (std::log10(deviation) - first(low)) / (last(high) - first(low));
  }
  static double first(double value) { return std::floor(std::log10(value) + 1e-9); }
  static double last(double value) {
    return std::ceil(std::log10(value) - 1e-9) + (std::log10(value) == std::floor(std::log10(value)));
  }
};

std::string grid(const Panel& panel, const std::string& unit) {
  std::string svg;
  for (double e = Panel::first(panel.low_tau); e <= Panel::last(panel.high_tau) + 0.5; ++e) {
    const double x = panel.x(std::pow(10, e));
    svg += fmt::format(
               R"(<path d="M{0:.1f} {1} V{2}" class="grid"/><text x="{0:.1f}" y="{3}" class="mid">1e{4:.0f}</text>)", x,
               top, height - bottom, height - bottom + 18, e) +
           "\n";
  }
  for (double e = Panel::first(panel.low); e <= Panel::last(panel.high) + 0.5; ++e) {
    const double y = panel.y(std::pow(10, e));
    svg += fmt::format(R"(<path d="M{} {:.1f} H{}" class="grid"/><text x="{}" y="{:.1f}" class="end">1e{:.0f}</text>)",
                       left, y, width - right, left - 8, y + 4, e) +
           "\n";
  }
  return svg +
         fmt::format(
             R"(<text x="{}" y="{}" class="mid">averaging time, s</text><text x="{}" y="{}">Allan deviation, {}</text>)",
             (left + width - right) / 2, height - 10, left, top - 10, unit) +
         "\n";
}

std::string curve(const Panel& panel, const AllanField& field, std::size_t index) {
  const std::string& colour = colours[index % colours.size()];
  std::string points, path;
  for (const auto& point : field.points) {
    if (!(point.variance > 0)) continue;
    points += fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="2.5" fill="{}"/>)", panel.x(point.tau),
                          panel.y(std::sqrt(point.variance)), colour);
    const double fitted = allan::variance_at(field.fit.estimates, point.tau);
    if (fitted > 0)
      path += fmt::format("{}{:.1f} {:.1f} ", path.empty() ? "M" : "L", panel.x(point.tau),
                          std::clamp(panel.y(std::sqrt(fitted)), top, height - bottom));
  }
  if (!path.empty()) points += fmt::format(R"(<path d="{}" stroke="{}" fill="none"/>)", path, colour);
  return points +
         fmt::format(R"(<text x="{}" y="{}" fill="{}">{}</text>)", width - right + 12,
                     top + 16 * static_cast<double>(index + 1), colour, field.name) +
         "\n";
}

}  // namespace

std::string allan_svg(const AllanChannel& channel) {
  std::map<std::string, Panel> panels;
  for (const AllanField& field : channel.fields)
    if (field.fit.used > 0) panels[field.unit].add(field);
  std::string body;
  double down = 0;
  for (const auto& [unit, panel] : panels) {
    body += fmt::format("<g transform=\"translate(0 {})\">\n", down) + grid(panel, unit);
    for (std::size_t i = 0; i < panel.fields.size(); ++i) body += curve(panel, *panel.fields[i], i);
    body += "</g>\n";
    down += height;
  }
  return fmt::format(
             R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0} {1}" width="{0}" height="{1}" font-family="sans-serif" font-size="12">
<style>.grid{{stroke:#ddd}} .mid{{text-anchor:middle}} .end{{text-anchor:end}}</style>
<rect width="{0}" height="{1}" fill="white"/>
)",
             width, std::max(down, 1.0)) +
         body + "</svg>\n";
}

}  // namespace binnacle::command
