// SPDX-License-Identifier: Apache-2.0
// load: the file, its guard, what it exports, whether it comes and goes.
#include <algorithm>
#include <fstream>
#include <set>

#include "miniature.hpp"

namespace binnacle::conform {

namespace {

/// What loading the library alone gave, by codes.
Diagnostics loading(const Trial& trial) {
  Catalog catalog;
  Diagnostics diagnostics;
  catalog.load(trial.library, diagnostics);
  return diagnostics;
}

/// Fails with every error that has one of these codes; warnings become warnings.
void report(Trial& trial, const Diagnostics& diagnostics, const std::vector<std::string>& codes) {
  for (const auto& item : diagnostics.items()) {
    if (std::find(codes.begin(), codes.end(), item.code) == codes.end()) continue;
    if (item.severity == Severity::error)
      trial.fail("[", item.code, "] ", item.message);
    else
      trial.warn("[", item.code, "] ", item.message);
  }
}

void file(Trial& trial) { report(trial, loading(trial), {"B040", "B044"}); }
void guard(Trial& trial) { report(trial, loading(trial), {"B041", "B042", "B043"}); }
/// Whatever the loader has against it besides.
void registration(Trial& trial) {
  const Diagnostics diagnostics = loading(trial);
  for (const auto& item : diagnostics.items())
    if (item.severity == Severity::error) trial.fail("[", item.code, "] ", item.message);
}

void symbols(Trial& trial) {
  const std::set<std::string> ours = {"binnacle_guard_v1", "binnacle_register_v1", "binnacle_types_v1"};
  for (const auto& symbol : exported_symbols(trial.library))
    trial.expect(ours.contains(symbol), "exports '", symbol,
                 "', which another library could bind to; link with the version script (binnacle_add_plugin does)");
}

/// Whether the library is mapped into this process.
bool is_mapped(const std::filesystem::path& library) {
  const std::string name = std::filesystem::canonical(library).string();
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (line.find(name) != std::string::npos) return true;
  return false;
}

void cycle(Trial& trial) {
  for (int i = 0; i < 100; ++i) {
    trial.stage("load");
    const Diagnostics diagnostics = loading(trial);
    trial.stage("");
    if (!trial.expect(!diagnostics.has_errors(), "the ", i + 1, "th load is refused: ", diagnostics.text())) return;
    if (!trial.expect(!is_mapped(trial.library),
                      "stays in memory after the last of its objects is gone: a unique symbol "
                      "(-fno-gnu-unique), a thread-local with a destructor, or -z nodelete pins it"))
      return;
  }
}

void unknown(Trial& trial) {
  const Catalog catalog = load_catalog(trial);
  for (const Role role : all_roles)
    trial.expect(!catalog.find(role, "no_such_component_as_this"), "an unknown type was found as a ", role_name(role));
}

}  // namespace

std::vector<Check> load_checks() {
  return {
      check("load.file", 1, {}, {}, "the file is there, a file, and not writable by everybody", file),
      check("load.guard", 1, {}, {"load.file"}, "its guard is present and equal to this program's", guard),
      check("load.symbols", 1, {}, {"load.guard"}, "it exports the entry symbols and nothing else", symbols),
      check("load.register", 1, {}, {"load.guard"},
            "it loads with all symbols bound, and what it registers is well declared", registration),
      check("load.cycle", 2, {}, {"load.register"},
            "it can be loaded and unloaded a hundred times, and is gone after each", cycle),
      check("load.unknown", 1, {}, {"load.register"}, "a type that it does not have is not found", unknown),
  };
}

}  // namespace binnacle::conform
