// SPDX-License-Identifier: Apache-2.0
// load, parse: a config from a file or a text, and what there is in it.
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "document/document.hpp"
#include "errors.hpp"
#include "explain_text.hpp"
#include "linked.hpp"
#include "loaded.hpp"
#include "models.hpp"
#include "wording/diagnostics_json.hpp"

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
  Loaded loaded{std::move(path), {}, nullptr};
  loaded.options.vars = std::move(vars);
  loaded.options.sets = std::move(sets);
  loaded.options.text = std::move(text);
  loaded.options.linked_plugins = linked_plugins();
  for (const auto& folder : folders) loaded.options.plugin_folders.emplace_back(folder);
  return loaded;
}

Loaded load(std::string path, std::optional<std::string> text, std::map<std::string, std::string> vars,
            std::vector<std::string> sets, const std::vector<std::string>& folders) {
  Loaded loaded = described(std::move(path), std::move(text), std::move(vars), std::move(sets), folders);
  loaded.composition = load_with_models(loaded.path, loaded.options);
  return loaded;
}

}  // namespace

void bind_composition(py::module_& module) {
  py::class_<Loaded>(module, "Loaded")
      .def_property_readonly("title", [](const Loaded& self) { return self.composition->title(); })
      .def_property_readonly("path", [](const Loaded& self) { return self.path.string(); })
      .def("config", [](const Loaded& self) { return to_python(Json::parse(self.composition->config())); })
      .def("warnings", [](const Loaded& self) { return to_python(self.composition->warnings()); })
      .def("explain",
           [](const Loaded& self) {
             const Json explained = document::explain(*self.composition);
             return py::make_tuple(to_python(explained),
                                   command::explanation_text(explained, Json::parse(self.composition->config())));
           })
      .def_property_readonly("plugins",
                             [](const Loaded& self) {
                               std::map<std::string, std::string> versions;
                               for (const auto& plugin : self.composition->catalog().plugins())
                                 versions[plugin.name] = plugin.version;
                               return versions;
                             })
      .def_property_readonly("filters",
                             [](const Loaded& self) {
                               std::vector<std::string> names;
                               for (const auto& filter : self.composition->filters()) names.push_back(filter.name);
                               return names;
                             })
      .def("subscribers",
           [](const Loaded& self, const std::string& channel) {
             std::vector<std::string> pointers;
             for (const auto& info : self.composition->channels())
               if (info.name == channel) pointers = info.subscribers;
             return pointers;
           })
      .def_property_readonly("channels", [](const Loaded& self) {
        std::vector<std::string> names;
        for (const auto& channel : self.composition->channels()) names.push_back(channel.name);
        return names;
      });
  module.def("load", &load, py::arg("path"), py::arg("text"), py::arg("vars"), py::arg("sets"), py::arg("folders"));
  module.def("resolved", &resolved, py::arg("path"), py::arg("text"), py::arg("vars"), py::arg("sets"));
  module.def("described", &described, py::arg("path"), py::arg("text"), py::arg("vars"), py::arg("sets"),
             py::arg("folders"));
}

}  // namespace binnacle::python
