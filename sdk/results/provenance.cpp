// SPDX-License-Identifier: Apache-2.0
#include "provenance.hpp"

namespace binnacle::results {

namespace {

std::string text_of(const Json& object, const char* key) {
  return object.contains(key) && object.at(key).is_string() ? object.at(key).get<std::string>() : std::string();
}

void put_text(nc::Group root, const char* name, const std::string& text) {
  if (!text.empty()) root.put_text(NC_GLOBAL, name, text);
}

void write_plugins(nc::Group root, const Json& plugins) {
  if (plugins.empty()) return;
  const int dimension = root.add_dimension("plugin", plugins.size());
  for (const auto& [variable, key, long_name] :
       {std::tuple{"plugin", "name", "plugins that were loaded"},
        std::tuple{"plugin_version", "version", "their versions"}, std::tuple{"plugin_path", "path", "their files"}}) {
    std::vector<std::string> texts;
    for (const auto& plugin : plugins) texts.push_back(text_of(plugin, key));
    root.put_text(root.add_texts(variable, {dimension}, texts), "long_name", long_name);
  }
}

}  // namespace

void write_provenance(nc::Group root, const std::string& kind, const Json& config, const Json& provenance) {
  const std::string version = text_of(provenance, "version"), created = text_of(provenance, "created"),
                    command = text_of(provenance, "command");
  root.put_text(NC_GLOBAL, "Conventions", "CF-1.10");
  put_text(root, "title", text_of(config, "title"));
  put_text(root, "comment", text_of(config, "description"));
  root.put_text(NC_GLOBAL, "source", "Binnacle " + version);
  put_text(root, "history", created.empty() || command.empty() ? command : created + " " + command);
  root.put_integer(NC_GLOBAL, "binnacle_layout", layout);
  root.put_text(NC_GLOBAL, "binnacle_kind", kind);
  put_text(root, "version", version);
  put_text(root, "command", command);
  put_text(root, "created", created);
  if (provenance.contains("seed")) root.put_natural(NC_GLOBAL, "seed", provenance.at("seed").get<std::uint64_t>());
  if (provenance.contains("run")) root.put_integer(NC_GLOBAL, "run", provenance.at("run").get<std::int64_t>());
  if (provenance.contains("plugins")) write_plugins(root, provenance.at("plugins"));
  const int id = root.add_texts("config", {}, {config.dump(2, ' ', false, Json::error_handler_t::replace)});
  root.put_text(id, "long_name", "the config as resolved: extends merged, variables and --set applied");
}

void read_provenance(nc::Group root, const std::string& kind, Json& config, Json& provenance) {
  if (!root.has(NC_GLOBAL, "binnacle_layout")) throw nc::Failure("it is a NetCDF file, but not one from Binnacle");
  if (root.natural(NC_GLOBAL, "binnacle_layout") != static_cast<std::uint64_t>(layout))
    throw nc::Failure("it was made by another version of Binnacle (" + root.text(NC_GLOBAL, "version") + ")");
  if (root.text(NC_GLOBAL, "binnacle_kind") != kind) throw nc::Failure("it is no " + kind);
  const auto variable = root.variable("config");
  const auto texts = variable ? root.read_texts(*variable) : std::vector<std::string>{};
  config = texts.size() == 1 ? Json::parse(texts[0], nullptr, false) : Json(Json::value_t::discarded);
  if (config.is_discarded()) throw nc::Failure("its variable 'config' is not JSON");
  provenance = Json::object();
  for (const char* key : {"version", "command"})
    if (root.has(NC_GLOBAL, key)) provenance[key] = root.text(NC_GLOBAL, key);
  if (root.has(NC_GLOBAL, "seed")) provenance["seed"] = root.natural(NC_GLOBAL, "seed");
  if (root.has(NC_GLOBAL, "run")) provenance["run"] = root.natural(NC_GLOBAL, "run");
  provenance["plugins"] = Json::array();
  const auto names = root.variable("plugin"), versions = root.variable("plugin_version"),
             paths = root.variable("plugin_path");
  if (names && versions && paths) {
    const auto name = root.read_texts(*names), version = root.read_texts(*versions), path = root.read_texts(*paths);
    for (std::size_t i = 0; i < name.size() && i < version.size() && i < path.size(); ++i)
      provenance["plugins"].push_back({{"name", name[i]}, {"version", version[i]}, {"path", path[i]}});
  }
  if (root.has(NC_GLOBAL, "created")) provenance["created"] = root.text(NC_GLOBAL, "created");
}

}  // namespace binnacle::results
