// SPDX-License-Identifier: Apache-2.0
// What was found, as JSON and as a page that needs no script.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "inspect/inspect.hpp"
#include "wording/markup.hpp"

namespace binnacle::inspect {

namespace {

const char* word(Severity severity) {
  return severity == Severity::warning ? "warning" : severity == Severity::finding ? "finding" : "unknown";
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

struct Range {
  double low = 1e300, high = -1e300;
  void take(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double at(double value, double from, double to) const {
    return from + (high > low ? (value - low) / (high - low) : 0.5) * (to - from);
  }
};

/// Minimum and maximum of each of at most 700 columns of the picture.
std::string path_of(const Plot::Line& line, const Range& x, const Range& y) {
  std::string path;
  const std::size_t per = std::max<std::size_t>(1, line.x.size() / 700);
  for (std::size_t first = 0; first < line.x.size(); first += per) {
    Range column;
    for (std::size_t i = first; i < std::min(first + per, line.x.size()); ++i) column.take(line.y[i]);
    if (column.high < column.low) continue;
    for (const double value : {column.low, column.high}) {
      path +=
          fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x.at(line.x[first], 60, 780), y.at(value, 190, 10));
      if (column.low == column.high) break;
    }
  }
  return path;
}

std::string picture(const Plot& plot) {
  Range x, y;
  for (const auto& line : plot.lines) {
    for (const double value : line.x) x.take(value);
    for (const double value : line.y) y.take(value);
  }
  if (x.high < x.low || y.high < y.low) return {};
  std::string svg =
      fmt::format("<figure><figcaption>{}</figcaption><svg viewBox=\"0 0 800 230\" role=\"img\" aria-label=\"{}\">",
                  wording::xml(plot.title), wording::xml(plot.title));
  svg += "<path class=\"axis\" d=\"M60 10V190H780\"/>";
  constexpr const char* colours[] = {"#1f77b4", "#d95f02", "#2ca02c", "#9467bd"};
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    svg += fmt::format("<path class=\"line\" stroke=\"{}\" d=\"{}\"/>", colours[i % 4], path_of(plot.lines[i], x, y));
    svg += fmt::format("<text x=\"{}\" y=\"24\" style=\"fill:{}\">{}</text>", 70 + 90 * i, colours[i % 4],
                       wording::xml(plot.lines[i].name));
  }
  svg += fmt::format(
      "<text x=\"55\" y=\"20\" text-anchor=\"end\">{0:.{2}g}</text><text x=\"55\" y=\"190\" "
      "text-anchor=\"end\">{1:.{2}g}</text>",
      y.high, y.low, y.high - y.low < 0.01 * std::abs(y.high) ? 6 : 4);
  svg += fmt::format(
      "<text x=\"60\" y=\"206\">{0:.{2}g}</text><text x=\"780\" y=\"206\" text-anchor=\"end\">{1:.{2}g}</text>", x.low,
      x.high, x.high - x.low < 0.01 * std::abs(x.high) ? 12 : 6);
  svg += fmt::format("<text x=\"420\" y=\"222\" text-anchor=\"middle\">{} · {}</text></svg></figure>",
                     wording::xml(plot.x_label), wording::xml(plot.y_label));
  return svg;
}

/// The fields of a channel, a picture for each unit.
std::vector<Plot> plots_of(const Channel& channel) {
  std::vector<Plot> plots;
  for (const Field& field : channel.fields) {
    if (field.si.empty() || field.name.find("_sd_") != std::string::npos || plots.size() > 5) continue;
    auto plot = std::ranges::find_if(plots, [&](const Plot& each) {
      return each.y_label == field.si && each.lines.size() < 3 && field.si != "rad";
    });
    if (plot == plots.end()) plot = plots.insert(plot, {channel.name + ": ", "s since the first label", field.si, {}});
    plot->title += (plot->lines.empty() ? "" : ", ") + field.name;
    plot->lines.push_back({field.name, channel.t, field.values});
  }
  return plots;
}

std::string row_of(const Finding& found) {
  return fmt::format("<tr class=\"{}\"><td>{}<td>{}<td>{}<td>{}{}<td>{}</tr>\n", word(found.severity),
                     word(found.severity), wording::xml(found.kind),
                     wording::xml(found.channel + (found.field.empty() ? "" : ": " + found.field)),
                     wording::xml(found.text),
                     found.meaning.is_null() ? "" : "<br><code>" + wording::xml(found.meaning.dump()) + "</code>",
                     wording::xml(found.evidence));
}

}  // namespace

Json to_json(const Inspection& inspection) {
  Json all;
  all["channels"] = Json::array();
  for (const Channel& channel : inspection.channels) {
    Json fields = Json::array();
    for (const Field& field : channel.fields)
      fields.push_back(
          {{"name", field.name}, {"column", field.column}, {"unit", field.unit}, {"guessed", field.is_guessed}});
    all["channels"].push_back({{"name", channel.name},
                               {"path", channel.path},
                               {"samples", channel.t.size()},
                               {"first_label_s", channel.first_label},
                               {"fields", fields}});
  }
  all["findings"] = Json::array();
  for (const Finding& found : inspection.findings)
    all["findings"].push_back(
        {{"id", found.channel + "/" + found.field + "/" + found.kind},
         {"severity", word(found.severity)},
         {"kind", found.kind},
         {"channel", found.channel},
         {"field", found.field},
         {"value", number(found.value)},
         {"sigma", number(found.sigma)},
         {"unit", found.unit},
         {"text", found.text},
         {"evidence", {{"figure", found.evidence}, {"from_s", number(found.from)}, {"to_s", number(found.to)}}},
         {"confidence", found.confidence},
         {"meaning", found.meaning}});
  if (inspection.mounting) {
    Json rows = Json::array();
    for (int i = 0; i < 3; ++i)
      rows.push_back({(*inspection.mounting)(i, 0), (*inspection.mounting)(i, 1), (*inspection.mounting)(i, 2)});
    all["mounting"] = rows;
  }
  return all;
}

std::string page(const Inspection& inspection, const std::string& title) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"color-scheme\" content=\"light "
      "dark\">"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\"><title>" +
      wording::xml(title) +
      "</title><style>body{font:15px/1.45 system-ui,sans-serif;max-width:76em;margin:2em auto;padding:0 1em}"
      "table{width:100%}th:nth-child(4){width:42%}th:nth-child(5){width:27%}td,th{box-shadow:"
      "0 1px #8884;padding:.3em "
      ".5em;text-align:left;vertical-align:top}"
      ".warning "
      "td:first-child{color:#c22;font-weight:600}.unknown{opacity:.75}code{font-size:85%;overflow-wrap:anywhere}"
      "svg{width:100%;height:auto}svg "
      "text{font-size:11px;fill:currentColor}.axis{stroke:currentColor;fill:none;opacity:.5}.line{fill:none;stroke-"
      "width:1}"
      "figure{margin:1.5em 0}figcaption{font-weight:600}</style></head><body>\n<h1>" +
      wording::xml(title) + "</h1>\n";
  html += "<table cellspacing=\"0\"><tr><th><th>kind<th>channel<th>what, and in the config<th>seen by</tr>\n";
  for (const Finding& found : inspection.findings) html += row_of(found);
  html += "</table>\n";
  for (const Plot& plot : inspection.plots) html += picture(plot);
  for (const Channel& channel : inspection.channels)
    for (const Plot& plot : plots_of(channel)) html += picture(plot);
  return html + "</body></html>\n";
}

}  // namespace binnacle::inspect
