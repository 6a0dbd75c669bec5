// SPDX-License-Identifier: Apache-2.0
// A whole config as a target, with the plugins of this build.
#pragma once

#include <memory>
#include <stdexcept>
#include <string_view>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "score/sections.hpp"
#include "target.hpp"

namespace binnacle::fuzz {

/// Null where the config is refused, which must be with words.
inline std::shared_ptr<const Composition> composed(std::string_view text) {
  LoadOptions options;
  options.plugin_folders = {BINNACLE_FUZZ_PLUGINS};
  try {
    return score::parse(text, "config.json", options);
  } catch (const Error& error) {
    if (error.diagnostics().empty()) throw std::logic_error("refused without a word");
    return nullptr;
  }
}

}  // namespace binnacle::fuzz
