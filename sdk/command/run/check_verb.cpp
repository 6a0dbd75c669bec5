// SPDX-License-Identifier: Apache-2.0
// check of the command itself: configs to run. What else a config may have is checked by the module that knows it.
#include <filesystem>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "check.hpp"
#include "output.hpp"
#include "score/sections.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

/// The key of the config that only the module checks; "" where there is none, or the config cannot be read.
std::string beyond_a_run(const fs::path& path, const LoadOptions& options) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return "";  // a pipe is read once
  try {
    const Config config = score::load_config(path, options);
    for (const char* key : {"study", "covariance", "tune"})
      if (config.contains(std::string("/") + key)) return key;
  } catch (const Error&) {
    // The check itself reports what is wrong.
  }
  return "";
}

Diagnostics warnings_of_run(const fs::path& path, const LoadOptions& options) {
  return score::compose(score::load_config(path, options), options)->warnings();
}

/// All configs to the module that knows the sections of one of them.
void hand_over_studies(const std::vector<std::string>& configs, const LoadOptions& options) {
  for (const auto& path : configs)
    if (const std::string key = beyond_a_run(path, options); !key.empty())
      hand_over(known_verb("study")->module, "'check' of a config with \"" + key + "\"", command_words());
}

}  // namespace

Verb check_verb(CLI::App& command) { return add_check(command, warnings_of_run, hand_over_studies); }

}  // namespace binnacle::command
