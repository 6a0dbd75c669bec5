// SPDX-License-Identifier: Apache-2.0
// Models written in Python: the classes that are registered, and the plugin "python" that they make.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"
#include "binnacle/registry.hpp"
#include "convert.hpp"

namespace binnacle::python {

/// The plugin's name; its types are "python/NAME".
inline constexpr const char* plugin_of_models = "python";

/// A Python object that C++ keeps. It is dropped under the GIL, from whatever thread; after Python has ended, never.
class Held {
 public:
  Held() = default;
  explicit Held(py::object object) : object_(std::move(object)) {}
  Held(Held&&) noexcept = default;
  /// Holds the GIL.
  Held& operator=(Held&& other) noexcept {
    object_ = std::move(other.object_);
    return *this;
  }
  ~Held() { drop(); }

  explicit operator bool() const { return static_cast<bool>(object_); }
  /// Holds the GIL.
  const py::object& get() const { return object_; }

 private:
  void drop();

  py::object object_;
};

/// A class that is registered. Its place is how a component finds it: a factory of the kernel is a plain function, so there
/// is one for each place.
class ModelClass {
 public:
  /// extras: by method, the arguments that it takes by name ("memory"). Throws ValueError where all places are taken.
  ModelClass(Role role, ComponentSpec spec, std::string code, py::object type, py::dict extras);
  ~ModelClass();
  ModelClass(const ModelClass&) = delete;
  ModelClass& operator=(const ModelClass&) = delete;

  const Role role;
  const ComponentSpec spec;
  const std::string code;  // a hash of what its methods do
  const Held type;
  const Held extras;
  const int place;

  static constexpr int most = 128;
  static const ModelClass& at(int place);
};

using ModelClasses = std::vector<std::shared_ptr<const ModelClass>>;

/// What is registered now. Holds the GIL.
ModelClasses all_models();

/// The plugin of these classes. Its version is a hash of their code.
std::shared_ptr<const LinkedPlugin> plugin_of(ModelClasses classes);

/// Makes the models' plugin and what binds them to their blocks part of the options; of no class: nothing.
void link_models(LoadOptions& options, ModelClasses classes);

/// Composes the config with the classes whose names stand in it, so that others are no part of what a snapshot is of; the
/// options then have their plugin. Throws what score::load throws. Holds the GIL, and releases it meanwhile.
std::shared_ptr<const Composition> load_with_models(const std::filesystem::path& path, LoadOptions& options);

void bind_models(py::module_& module);
void bind_model_specs(py::module_& module);

}  // namespace binnacle::python
