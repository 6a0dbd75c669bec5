// SPDX-License-Identifier: Apache-2.0
// What the tests of the loader share: the plugins that were built for them, and folders of their own.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/catalog.hpp"
#include "catch.hpp"

namespace loader_work {

using namespace binnacle;
namespace fs = std::filesystem;

using Lines = std::vector<std::string>;

inline const fs::path folder = BINNACLE_LOADER_TEST_PLUGINS;

inline fs::path plugin_at(const std::string& name) { return fs::canonical(folder) / (name + ".so"); }

/// The messages, without the folder that they begin with.
inline Lines lines(const Diagnostics& diagnostics) {
  Lines result;
  for (const Diagnostic& item : diagnostics.items()) {
    std::string text = to_string(item);
    const std::string prefix = fs::canonical(folder).string() + "/";
    for (std::size_t at = 0; (at = text.find(prefix, at)) != std::string::npos;) text.erase(at, prefix.size());
    result.push_back(text);
  }
  return result;
}

inline Lines load(const std::string& name) {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(plugin_at(name), diagnostics);
  if (diagnostics.has_errors()) CHECK(catalog.types().empty());
  return lines(diagnostics);
}

/// A variable of the environment, for as long as this lives.
struct Variable {
  Variable(const char* name_, const std::string& value) : name(name_) { ::setenv(name, value.c_str(), 1); }
  ~Variable() { ::unsetenv(name); }
  const char* name;
};

/// A folder that is gone with the test.
struct Scratch {
  Scratch() : path(fs::temp_directory_path() / ("binnacle_catalog_" + std::to_string(::getpid()))) {
    fs::create_directories(path);
    path = fs::canonical(path);
  }
  ~Scratch() { fs::remove_all(path); }
  fs::path path;
};

/// Emits nothing; its spec says which of two it is.
struct Idle final : Source {
  explicit Idle(const Binding&) {}
  SourceStatus next(const MemoryView&, SourceOutput&) const override { return SourceStatus::end; }
  static ComponentSpec named(const std::string& type) {
    ComponentSpec spec;
    spec.type = type;
    spec.summary = "emits nothing";
    return spec;
  }
};

inline std::shared_ptr<LinkedPlugin> linked(const std::string& name, const std::vector<std::string>& types) {
  return std::make_shared<LinkedPlugin>(LinkedPlugin{name, "3", [types](Registry& registry) {
                                                       for (const auto& type : types)
                                                         registry.add<Idle>(Idle::named(type));
                                                     }});
}

}  // namespace loader_work
