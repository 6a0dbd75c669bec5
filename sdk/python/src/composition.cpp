// SPDX-License-Identifier: Apache-2.0
// load, parse: a config from a file or a text, and what there is in it.
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "binnacle/catalog.hpp"
#include "document/document.hpp"
#include "errors.hpp"
#include "explain_text.hpp"
#include "linked.hpp"
#include "loaded.hpp"
#include "models.hpp"
#include "score/sections.hpp"
#include "study/study.hpp"
#include "warnings.hpp"
#include "wording/diagnostics_json.hpp"
#include "wording/wording.hpp"

namespace binnacle::python {

namespace {

/// The config with its extends, variables and settings, before it is composed.
py::object resolved(const std::string& path, std::optional<std::string> text, std::map<std::string, std::string> vars,
                    std::vector<std::string> sets) {
  LoadOptions options;
  options.vars = std::move(vars);
  options.sets = std::move(sets);
  options.text = std::move(text);
  return to_python(Json::parse(Config::load(path, options).text()));
}

/// With how it is to be loaded, and not loaded yet: for what composes a config in its own way.
Loaded described(std::string path, std::optional<std::string> text, std::map<std::string, std::string> vars,
                 std::vector<std::string> sets, const std::vector<std::string>& folders) {
  Loaded loaded{std::move(path), {}, nullptr, nullptr};
  loaded.options.vars = std::move(vars);
  loaded.options.sets = std::move(sets);
  loaded.options.text = std::move(text);
  loaded.options.linked_plugins = linked_plugins();
  for (const auto& folder : folders) loaded.options.plugin_folders.emplace_back(folder);
  return loaded;
}

/// Of its study; none where it has none.
std::vector<std::string> variants(const Loaded& loaded) {
  const Config config = score::load_config(loaded.path, loaded.options);
  std::vector<std::string> names;
  if (!study::Study::is_in(config)) return names;
  Diagnostics diagnostics;
  for (const auto& variant : study::variants_of(config, diagnostics)) names.push_back(variant.name);
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  return names;
}

Diagnostics warnings(const Loaded& loaded) {
  const py::gil_scoped_release unlocked;
  return command::warnings_of(loaded.path, loaded.options);
}

Loaded load(std::string path, std::optional<std::string> text, std::map<std::string, std::string> vars,
            std::vector<std::string> sets, const std::vector<std::string>& folders, const std::string& variant) {
  Loaded loaded = described(std::move(path), std::move(text), std::move(vars), std::move(sets), folders);
  if (!variant.empty()) loaded.options.patches = study::patches_of(loaded.path, loaded.options, variant);
  try {
    loaded.composition = load_with_models(loaded.path, loaded.options);
  } catch (const ConfigError& error) {
    const auto names = variants(loaded);
    if (!variant.empty() || names.empty()) throw;
    std::vector<std::string> quoted;
    for (const auto& name : names) quoted.push_back(wording::in_quotes(name));
    Diagnostics diagnostics = error.diagnostics();
    diagnostics.error("", {loaded.path.string(), 0, 0}, "/study",
                      "the config is complete only as a variant of its study: variant=NAME of load(), one of " +
                          wording::listed(quoted));
    loaded.failure = std::make_exception_ptr(ConfigError(diagnostics));
  }
  if (loaded.failure) warnings(loaded);  // throws what is wrong with the variants
  return loaded;
}

}  // namespace

void bind_composition(py::module_& module) {
  py::class_<Loaded>(module, "Loaded")
      .def_property_readonly("is_complete", [](const Loaded& self) { return !self.failure; })
      .def_property_readonly("variants", &variants)
      .def_property_readonly("path", [](const Loaded& self) { return self.path.string(); })
      .def("config",
           [](const Loaded& self) {
             const bool is_complete = !self.failure;
             return to_python(Json::parse(is_complete ? self.composition->config()
                                                      : score::load_config(self.path, self.options).text()));
           })
      .def("warnings", [](const Loaded& self) { return to_python(warnings(self)); })
      .def("explain",
           [](const Loaded& self) {
             const Json explained = document::explain(*self.composed());
             return py::make_tuple(to_python(explained),
                                   command::explanation_text(explained, Json::parse(self.composed()->config())));
           })
      .def_property_readonly("plugins",
                             [](const Loaded& self) {
                               std::map<std::string, std::string> versions;
                               for (const auto& plugin : self.composed()->catalog().plugins())
                                 versions[plugin.name] = plugin.version;
                               return versions;
                             })
      .def_property_readonly("filters",
                             [](const Loaded& self) {
                               std::vector<std::string> names;
                               for (const auto& filter : self.composed()->filters()) names.push_back(filter.name);
                               return names;
                             })
      .def("subscribers",
           [](const Loaded& self, const std::string& channel) {
             std::vector<std::string> pointers;
             for (const auto& info : self.composed()->channels())
               if (info.name == channel) pointers = info.subscribers;
             return pointers;
           })
      .def_property_readonly("channels", [](const Loaded& self) {
        std::vector<std::string> names;
        for (const auto& channel : self.composed()->channels()) names.push_back(channel.name);
        return names;
      });
  module.def("load", &load, py::arg("path"), py::arg("text"), py::arg("vars"), py::arg("sets"), py::arg("folders"),
             py::arg("variant"));
  module.def("resolved", &resolved, py::arg("path"), py::arg("text"), py::arg("vars"), py::arg("sets"));
  module.def("described", &described, py::arg("path"), py::arg("text"), py::arg("vars"), py::arg("sets"),
             py::arg("folders"));
}

}  // namespace binnacle::python
