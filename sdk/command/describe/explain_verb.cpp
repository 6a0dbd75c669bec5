// SPDX-License-Identifier: Apache-2.0
// explain: a dry run for people. State layout, who moves and reads what, channels, what is unused.
#include <fmt/format.h>

#include "binnacle/unit.hpp"
#include "document/document.hpp"
#include "explain_text.hpp"
#include "output.hpp"
#include "score/sections.hpp"
#include "table.hpp"
#include "verbs.hpp"

namespace binnacle::command {

namespace {

std::vector<std::string> texts(const Json& list) { return list.get<std::vector<std::string>>(); }

std::string listed_or_dash(const Json& list) { return list.empty() ? "-" : joined(texts(list)); }

std::string section(const std::string& title, const Table& table) {
  return table.empty() ? "" : fmt::format("\n{}\n{}", title, table.text());
}

// ---- channels and who makes them

std::string sources_text(const Json& sources) {
  Table table("lll");
  for (const auto& source : sources)
    table.row({source.at("name"), source.at("type"), "emits " + listed_or_dash(source.at("outputs"))});
  return section("Sources", table);
}

std::string transforms_text(const Json& transforms) {
  Table table("llll");
  for (const auto& transform : transforms)
    table.row({transform.at("name"), transform.at("type"), "subscribes to " + listed_or_dash(transform.at("inputs")),
               "emits " + listed_or_dash(transform.at("outputs"))});
  return section("Transforms", table);
}

std::string field_text(const Json& field) {
  std::string text = field.at("name");
  const std::string unit = field.at("unit"), kind = field.at("kind");
  if (!unit.empty()) text += " [" + unit + "]";
  if (kind != "level") text += " " + kind;
  return field.at("per_row").get<bool>() ? text + " per row" : text;
}

std::string channels_text(const Json& channels) {
  std::string text;
  for (const auto& channel : channels) {
    std::vector<std::string> fields;
    for (const auto& field : channel.at("fields")) fields.push_back(field_text(field));
    text += fmt::format("  {}\n    {}\n    subscribers: {}\n", channel.at("name").get<std::string>(),
                        fields.empty() ? "no fields" : joined(fields),
                        channel.at("subscribers").empty() ? "nobody" : joined(texts(channel.at("subscribers"))));
  }
  return text.empty() ? "" : "\nChannels\n" + text;
}

// ---- a filter

std::string value_text(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

/// As the config says it: `sigma` of the block for this component, or the channel that it comes from.
std::string initial_sigma(const Json& block_config, const std::string& component, std::size_t index) {
  if (block_config.contains("sigma")) {
    const auto& sigma = block_config.at("sigma");
    if (sigma.is_object()) return sigma.contains(component) ? value_text(sigma.at(component)) : "";
    if (sigma.is_array()) return index < sigma.size() ? value_text(sigma.at(index)) : "";
    return value_text(sigma);
  }
  const auto init = block_config.find("init");
  return init != block_config.end() && init->is_object() && init->contains("channel")
             ? "from " + value_text(init->at("channel"))
             : "";
}

std::string layout_text(const Json& filter, const Json& filter_config) {
  Table table("rllll");
  table.row({"row", "component", "unit", "use", "sigma at the start"});
  for (const auto& block : filter.at("blocks")) {
    const std::string name = block.at("name");
    const Json& block_config = filter_config.at("blocks").at(name);
    std::size_t index = 0;
    for (const auto& component : block.at("components")) {
      const std::string label = component.at("name");
      table.row({component.contains("row") ? component.at("row").dump() : "-", name + "." + label, component.at("unit"),
                 component.at("use"), component.contains("row") ? initial_sigma(block_config, label, index) : ""});
      ++index;
    }
  }
  return section("State", table);
}

/// With where its Jacobians come from, when not from a pencil.
std::string type_text(const Json& model) {
  const std::string type = model.at("type");
  return model.contains("jacobians") ? type + " (Jacobians by " + value_text(model.at("jacobians")) + ")" : type;
}

std::string blocks_text(const Json& filter) {
  Table table("llll");
  for (const auto& block : filter.at("blocks")) {
    const std::string process = block.at("advanced_by");
    table.row({block.at("name"), block.at("type"), block.at("kind"),
               process.empty() ? "advanced by nothing" : "advanced by " + process});
  }
  for (const auto& derived : filter.at("derived"))
    table.row({derived.at("name"), type_text(derived), derived.at("kind"),
               "derived of " + listed_or_dash(derived.at("reads"))});
  return section("Blocks", table);
}

std::string processes_text(const Json& filter) {
  Table table("lllll");
  for (const auto& process : filter.at("process"))
    table.row({process.at("name"), type_text(process), "advances " + listed_or_dash(process.at("advances")),
               "reads " + listed_or_dash(process.at("reads")),
               process.contains("input") ? "driven by " + value_text(process.at("input")) : ""});
  std::string points;
  if (filter.contains("propagation"))
    points = fmt::format("  propagated by sigma points, up to {} a step: x, Phi and Qd are made of them\n",
                         filter.at("propagation").at("most_sigma_points").dump());
  return section("Process models", table) + points;
}

/// Rows move with columns: x where Φ couples them, \ for a block with itself.
std::string couplings_text(const Json& filter) {
  if (filter.at("couplings").empty()) return {};
  std::vector<std::string> names;
  for (const auto& block : filter.at("blocks")) names.push_back(block.at("name"));
  Table table(std::string(names.size() + 1, 'l'));
  std::vector<std::string> heads{""};
  heads.insert(heads.end(), names.begin(), names.end());
  table.row(std::move(heads));
  for (const auto& to : names) {
    std::vector<std::string> row{to};
    for (const auto& from : names) {
      bool is_coupled = false;
      for (const auto& coupling : filter.at("couplings"))
        is_coupled = is_coupled || (coupling.at("to") == to && coupling.at("from") == from);
      row.push_back(to == from ? "\\" : is_coupled ? "x" : ".");
    }
    table.row(std::move(row));
  }
  return section("Couplings (x: the error of the row is moved by that of the column)", table);
}

std::string parts_text(const Json& measurement) {
  std::vector<std::string> parts;
  for (const auto& part : measurement.at("parts"))
    parts.push_back(fmt::format("{} sees {}", type_text(part), listed_or_dash(part.at("reads"))));
  return joined(parts, "; ");
}

std::string gate_text(const Json& measurement) {
  if (!measurement.contains("gate")) return "no gate";
  const auto& gate = measurement.at("gate");
  const auto by = gate.at("by").get<std::string>();
  const char* const recovery = gate.at("recovers").get<bool>() ? "" : ", no recovery";
  if (by == "key") return fmt::format("gate {} by key{}", gate.at("probability").dump(), recovery);
  return fmt::format("gate {}{} (NIS <= {}){}", gate.at("probability").dump(), by == "row" ? " by row" : "",
                     figure(gate.at("nis_limit").get<double>()), recovery);
}

std::string update_text(const Json& measurement) {
  if (!measurement.contains("update")) return "";
  const auto& update = measurement.at("update");
  const auto type = update.at("type").get<std::string>();
  if (!update.contains("max")) return type;
  return fmt::format("{}, at most {} linearizations, to {} sigma", type, update.at("max").dump(),
                     figure(update.at("tolerance").get<double>()));
}

std::string measurements_text(const Json& filter) {
  Table table("lllllll");
  for (const auto& measurement : filter.at("measurements"))
    table.row({measurement.at("name"), "on " + value_text(measurement.at("channel")), parts_text(measurement),
               "up to " + counted(measurement.at("max_rows"), "row"), gate_text(measurement),
               measurement.contains("noise") ? "noise " + value_text(measurement.at("noise")) : "",
               update_text(measurement)});
  return section("Measurements", table);
}

std::string implied_states_text(const Json& filter) {
  if (!filter.contains("implied_states")) return {};
  Table table("lll");
  for (const auto& implied_state : filter.at("implied_states"))
    table.row({implied_state.at("name"), "of " + value_text(implied_state.at("block")),
               "by " + value_text(implied_state.at("measurement"))});
  return section("Implied states", table);
}

std::string start_text(const Json& filter) {
  std::vector<std::string> channels;
  for (const auto& initial : filter.at("starts_when")) {
    std::string text = initial.at("channel");
    if (initial.contains("max_age_s")) text += fmt::format(" (no older than {})", duration(initial.at("max_age_s")));
    channels.push_back(std::move(text));
  }
  return channels.empty() ? "\nStarts with the first sample that it receives\n"
                          : fmt::format("\nStarts when there is a sample of {}\n", joined(channels, " and "));
}

std::string history_text(const Json& filter) {
  if (!filter.contains("history")) return "";
  const Json& history = filter.at("history");
  const std::string budget = history.contains("steps") ? fmt::format(", and work on {} instants for each that arrives",
                                                                     history.at("steps").dump())
                                                       : "";
  return fmt::format(
      "History of {}: settled estimates on channel {}; live ones keep snapshots of at most {:.0f} kB{}\n",
      duration(history.at("length_s")), history.at("settled").get<std::string>(),
      history.at("snapshot_bytes").get<double>() / 1e3, budget);
}

/// Models that Python brings: the command can not run them.
std::string python_text(const Json& filter) {
  Table table("lll");
  for (const auto& mark : filter.value("written_in_python", Json::array()))
    table.row({mark.at("component"), mark.at("role"), mark.at("type")});
  return section("Written in Python: slower, and unknown to the command", table);
}

std::string filter_text(const Json& filter, const Json& filter_config) {
  const std::string name = filter.at("name");
  const std::string form = filter.at("covariance");
  return fmt::format("\nFILTER {}: {} in the covariance{}\n", name, counted(filter.at("dof"), "row"),
                     form == "joseph" ? "" : ", kept as " + form) +
         layout_text(filter, filter_config) + blocks_text(filter) + processes_text(filter) + couplings_text(filter) +
         measurements_text(filter) + implied_states_text(filter) + start_text(filter) + history_text(filter) +
         python_text(filter);
}

/// Figures that components found out while they were bound; angles in degrees, as everywhere in print.
std::string found_text(const Json& found) {
  Table table("llrl");
  for (const auto& component : found) {
    std::string at = component.at("at");
    for (const auto& finding : component.at("figures")) {
      double value = finding.at("value");
      std::string unit = finding.at("unit");
      if (unit == "rad") {
        value /= parse_unit("deg")->scale;
        unit = "deg";
      }
      table.row({at, finding.at("name"), figure(value), unit == "1" ? "" : unit});
      at.clear();
    }
  }
  return section("Found", table);
}

}  // namespace

std::string explanation_text(const Json& explained, const Json& config) {
  const std::string title = explained.at("title");
  std::string text = title.empty() ? "" : title + "\n";
  text += sources_text(explained.at("sources")) + transforms_text(explained.at("transforms")) +
          channels_text(explained.at("channels"));
  for (const auto& filter : explained.at("filters"))
    text += filter_text(filter, config.at("filters").at(filter.at("name").get<std::string>()));
  text += found_text(explained.at("found"));
  text +=
      fmt::format("\nUnused channels: {}\n",
                  explained.at("unused_channels").empty() ? "none" : joined(texts(explained.at("unused_channels"))));
  text += fmt::format("A snapshot takes {} bytes\n", explained.at("arena_bytes").dump());
  text.erase(0, text.find_first_not_of('\n'));
  return text;
}

namespace {

struct ExplainVerbOptions {
  std::string config_path;
  ConfigOptions config;
  bool json = false;
};

int explain(const ExplainVerbOptions& options) {
  const auto composition = score::load(options.config_path, options.config.load_options(options.config_path));
  print_diagnostics(composition->warnings());
  const Json explained = document::explain(*composition);
  if (options.json)
    print_json(explained);
  else
    print(explanation_text(explained, Json::parse(composition->config())));
  return ok;
}

}  // namespace

Verb explain_verb(CLI::App& command) {
  const auto options = std::make_shared<ExplainVerbOptions>();
  CLI::App* app = add_verb(command, "explain");
  app->add_option("CONFIG", options->config_path, "The config")->required();
  options->config.add_to(*app);
  options->config.add_variant_to(*app);
  app->add_flag("--json", options->json, "As JSON");
  return {app, [options] { return explain(*options); }};
}

}  // namespace binnacle::command
