// SPDX-License-Identifier: Apache-2.0
#include "tune_text.hpp"

#include <fmt/format.h>

#include "table.hpp"

namespace binnacle::command {

namespace {

std::string shown(const Json& value) {
  if (value.is_number()) return figure(value.get<double>());
  if (!value.is_string()) return "-";
  const auto text = value.get<std::string>();
  std::size_t end = 0;
  const double number = std::stod(text, &end);
  return figure(number) + text.substr(end);
}

std::string error_of(const Json& parameter) {
  if (!parameter.contains("standard_error")) return "-";
  const double error = parameter.at("standard_error").get<double>();
  return parameter.at("relative").get<bool>() ? fmt::format("{:.1f} %", 100 * error) : figure(error);
}

/// "determined"; with evidence below 2, what that says.
std::string state_of(const Json& parameter) {
  const Json evidence = parameter.value("evidence", Json());
  const auto state = parameter.at("state").get<std::string>();
  return evidence.is_number() && evidence.get<double>() < 2 ? state + "; the start was as good" : state;
}

std::string parameters_text(const Json& result) {
  Table table("lrrrrl");
  table.row({"parameter", "start", "end", "standard error", "evidence", ""});
  for (const auto& parameter : result.at("parameters"))
    table.row({parameter.at("name").get<std::string>(), shown(parameter.at("start")),
               shown(parameter.value("end", Json())), error_of(parameter), shown(parameter.value("evidence", Json())),
               state_of(parameter)});
  return table.text();
}

/// Likelihood, NIS per row and withheld samples, at the start and at the end.
std::string judged_text(const std::string& name, const Json& judged) {
  if (judged.contains("failure")) return fmt::format("{}: {}\n", name, judged.at("failure").get<std::string>());
  const Json& likelihood = judged.at("likelihood");
  Table table("lrr");
  table.row({name, "start", "end"});
  table.row({fmt::format("ln likelihood of {:.0f} rows that both accept", likelihood.at("rows").get<double>()),
             fmt::format("{:.1f}", likelihood.at("start").get<double>()),
             fmt::format("{:.1f}", likelihood.at("end").get<double>())});
  table.row({"rows accepted", fmt::format("{:.0f}", likelihood.at("rows_start").get<double>()),
             fmt::format("{:.0f}", likelihood.at("rows_end").get<double>())});
  for (const auto& [measurement, ends] : judged.at("measurements").items()) {
    const Json start = ends.value("start", Json::object()), end = ends.value("end", Json::object());
    table.row({measurement + ": NIS per row", shown(start.value("nis_per_row", Json())),
               shown(end.value("nis_per_row", Json()))});
    if (!start.contains("withheld") || !end.contains("withheld")) continue;
    const Json &before = start.at("withheld"), &after = end.at("withheld");
    table.row(
        {measurement + ": withheld, -ln p per row", shown(before.at("nll_per_row")), shown(after.at("nll_per_row"))});
    for (const auto& [group, rms] : before.at("rms").items())
      if (after.at("rms").contains(group))
        table.row({fmt::format("{}: withheld, RMS of {} [{}]", measurement, group, rms.at("unit").get<std::string>()),
                   shown(rms.at("value")), shown(after.at("rms").at(group).at("value"))});
  }
  return table.text();
}

}  // namespace

std::string tune_text(const Json& result, const tune::Plan& plan) {
  std::string text = heading(plan.title);
  text += parameters_text(result) + "\n";
  for (const auto& open : result.at("undetermined"))
    text += "  not determined: " + open.at("text").get<std::string>() + "\n";
  if (!result.at("undetermined").empty()) text += "\n";
  text += fmt::format("  {}, {} evaluations, {} rounds, {} runs\n\n", result.at("objective").get<std::string>(),
                      result.at("evaluations").get<int>(), result.at("rounds").size(), result.at("runs").get<int>());
  const Json& judged = result.at("judged");
  text += judged_text("used", judged.at("used")) + "\n";
  if (judged.contains("unseen"))
    for (const auto& [name, part] : judged.at("unseen").items()) text += judged_text("unseen: " + name, part) + "\n";
  return text;
}

}  // namespace binnacle::command
