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

Loaded load(std::string path, std::optional<std::string> text, std::map<std::string, std::string> vars,
            std::vector<std::string> sets, const std::vector<std::string>& folders) {
  Loaded loaded{std::move(path), {}, nullptr};
  loaded.options.vars = std::move(vars);
  loaded.options.sets = std::move(sets);
  loaded.options.text = std::move(text);
  loaded.options.linked_plugins = linked_plugins();
  for (const auto& folder : folders) loaded.options.plugin_folders.emplace_back(folder);
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
      .def_property_readonly("channels", [](const Loaded& self) {
        std::vector<std::string> names;
        for (const auto& channel : self.composition->channels()) names.push_back(channel.name);
        return names;
      });
  module.def("load", &load, py::arg("path"), py::arg("text"), py::arg("vars"), py::arg("sets"), py::arg("folders"));
}

}  // namespace binnacle::python
