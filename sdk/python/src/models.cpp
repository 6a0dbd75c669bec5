// SPDX-License-Identifier: Apache-2.0
#include "models.hpp"

#include <array>
#include <atomic>
#include <cstdio>
#include <map>
#include <stdexcept>

#include <pybind11/stl.h>

#include "binnacle/catalog.hpp"
#include "linked.hpp"
#include "models_adapters.hpp"
#include "models_manifolds.hpp"
#include "models_spec.hpp"
#include "score/sections.hpp"

namespace binnacle::python {

namespace {

std::array<std::atomic<const ModelClass*>, ModelClass::most> places{};

int take_place(const ModelClass* of) {
  for (int i = 0; i < ModelClass::most; ++i) {
    const ModelClass* nobody = nullptr;
    if (places[static_cast<std::size_t>(i)].compare_exchange_strong(nobody, of)) return i;
  }
  throw py::value_error("no more than " + std::to_string(ModelClass::most) +
                        " model classes can be in use at a time; those of compositions that are kept count as well");
}

/// By name. Never destroyed: Python's own end comes first.
std::map<std::string, std::shared_ptr<const ModelClass>>& registered() {
  static auto& all = *new std::map<std::string, std::shared_ptr<const ModelClass>>;
  return all;
}

/// A component of the class that has this place.
template <class Adapter, int place>
class Placed final : public Adapter {
 public:
  template <class... Bindings>
  explicit Placed(const Bindings&... bindings) : Adapter(ModelClass::at(place), bindings...) {}
};

using Add = void (*)(Registry&, const ComponentSpec&);

template <class Adapter, int... place>
constexpr std::array<Add, sizeof...(place)> adders(std::integer_sequence<int, place...>) {
  return {{[](Registry& registry, const ComponentSpec& spec) { registry.add<Placed<Adapter, place>>(spec); }...}};
}

template <class Adapter>
void add(Registry& registry, const ModelClass& model) {
  static constexpr auto all = adders<Adapter>(std::make_integer_sequence<int, ModelClass::most>());
  all[static_cast<std::size_t>(model.place)](registry, model.spec);
}

void add(Registry& registry, const ModelClass& model) {
  switch (model.role) {
    case Role::measurement_model: return add<PythonMeasurement>(registry, model);
    case Role::process_model: return add<PythonProcess>(registry, model);
    case Role::noise_estimator: return add<PythonNoise>(registry, model);
    case Role::derived_block: return add<PythonDerived>(registry, model);
    case Role::transform: return add<PythonTransform>(registry, model);
    default: throw std::logic_error("a model in Python can not have this role");
  }
}

/// Whether the name, in quotes, is the value of a member.
bool is_value_in(const std::string& config_text, const std::string& name) {
  const std::string quoted = '"' + name + '"';
  for (auto at = config_text.find(quoted); at != std::string::npos; at = config_text.find(quoted, at + 1)) {
    const auto before = at == 0 ? std::string::npos : config_text.find_last_not_of(" \n", at - 1);
    if (before != std::string::npos && config_text[before] == ':') return true;
  }
  return false;
}

/// Those that the config may mean by a type.
ModelClasses named_in(const std::string& config_text, const ModelClasses& all) {
  ModelClasses named;
  for (const auto& model : all)
    if (const std::string& name = model->spec.type;
        is_value_in(config_text, name) || is_value_in(config_text, std::string(plugin_of_models) + "/" + name))
      named.push_back(model);
  return named;
}

std::string version_of(const ModelClasses& classes) {
  // FNV-1a over what is a hash already.
  std::uint64_t hash = 0xcbf2'9ce4'8422'2325;
  for (const auto& model : classes)
    for (const char c : model->spec.type + "=" + model->code + ";")
      hash = (hash ^ static_cast<unsigned char>(c)) * 0x100'0000'01b3;
  char text[32];
  std::snprintf(text, sizeof text, "0.0.0+%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace

void Held::drop() {
  if (!object_) return;
  if (!Py_IsInitialized()) {
    object_.release();
    return;
  }
  const py::gil_scoped_acquire locked;
  object_ = py::object();
}

ModelClass::ModelClass(Role role_, ComponentSpec spec_, std::string code_, py::object type_, py::dict extras_)
    : role(role_),
      spec(std::move(spec_)),
      code(std::move(code_)),
      type(std::move(type_)),
      extras(std::move(extras_)),
      place(take_place(this)) {}

ModelClass::~ModelClass() { places[static_cast<std::size_t>(place)].store(nullptr); }

const ModelClass& ModelClass::at(int place) { return *places[static_cast<std::size_t>(place)].load(); }

ModelClasses all_models() {
  ModelClasses all;
  for (const auto& [name, model] : registered()) all.push_back(model);
  return all;
}

std::shared_ptr<const LinkedPlugin> plugin_of(ModelClasses classes) {
  std::string version = version_of(classes);
  const auto add_types = [classes = std::move(classes)](Registry& registry) {
    for (const auto& model : classes) add(registry, *model);
  };
  return std::make_shared<const LinkedPlugin>(LinkedPlugin{plugin_of_models, std::move(version), add_types});
}

void link_models(LoadOptions& options, ModelClasses classes) {
  if (classes.empty()) return;
  options.linked_plugins.push_back(plugin_of(std::move(classes)));
  options.sections.push_back(manifolds_section());
}

std::shared_ptr<const Composition> load_with_models(const std::filesystem::path& path, LoadOptions& options) {
  const ModelClasses all = all_models();
  const py::gil_scoped_release unlocked;
  const LoadOptions given = options;
  const std::string text = score::load_config(path, options).text();
  if (!wants_arrays(text)) options.linked_plugins.clear();
  link_models(options, named_in(text, all));
  try {
    return score::load(path, options);
  } catch (const Error&) {
    // A misspelt name is near one that is there: with all of them the message says so.
  }
  options = given;
  link_models(options, all);
  return score::load(path, options);
}

void bind_models(py::module_& module) {
  bind_model_specs(module);
  bind_model_bindings(module);
  module.def(
      "register_model",
      [](const std::string& name, int role, py::object spec, const std::string& code, py::object type,
         py::dict extras) {
        registered()[name] = std::make_shared<const ModelClass>(static_cast<Role>(role), spec_of(name, spec), code,
                                                                std::move(type), std::move(extras));
      },
      py::arg("name"), py::arg("role"), py::arg("spec"), py::arg("code"), py::arg("type"), py::arg("extras"));
  module.def("library_at", &library_at, py::arg("address"));
  module.def("unregister_model", [](const std::string& name) { return registered().erase(name) > 0; });
  py::dict roles;
  for (const Role role :
       {Role::measurement_model, Role::process_model, Role::noise_estimator, Role::derived_block, Role::transform})
    roles[role_name(role)] = static_cast<int>(role);
  module.attr("roles") = roles;
}

}  // namespace binnacle::python
