// SPDX-License-Identifier: Apache-2.0
// A whole config as a target, with the plugins of this build.
#pragma once

#include <dlfcn.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string_view>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "score/sections.hpp"
#include "target.hpp"

namespace binnacle::fuzz {

/// Of a library that was unloaded libFuzzer reads the counters all the same.
inline void keep_plugins_loaded() {
  for (const auto& entry : std::filesystem::directory_iterator(BINNACLE_FUZZ_PLUGINS))
    if (entry.path().extension() == ".so" && !::dlopen(entry.path().c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE))
      throw std::logic_error(::dlerror());
}

/// Null where the config is refused, which must be with words.
inline std::shared_ptr<const Composition> composed(std::string_view text) {
  static const bool kept = (keep_plugins_loaded(), true);
  LoadOptions options;
  if (kept) options.plugin_folders = {BINNACLE_FUZZ_PLUGINS};
  try {
    return score::parse(text, "config.json", options);
  } catch (const Error& error) {
    if (error.diagnostics().empty()) throw std::logic_error("refused without a word");
    return nullptr;
  }
}

}  // namespace binnacle::fuzz
