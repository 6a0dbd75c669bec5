// SPDX-License-Identifier: Apache-2.0
// The gallery: configs to begin with, and what has to come along where one is copied.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace binnacle::command {

struct Example {
  std::string name;  // of the gallery; else the path as it was given
  std::string title;
  std::filesystem::path config;
};

/// Those of the gallery, by name.
std::vector<Example> gallery();

/// A line each: name and title.
std::string listed(const std::vector<Example>& examples);

/// One of the gallery, or the config at this path. UsageError where there is neither: the nearest name, and all that there are.
Example example(const std::string& name_or_path);

/// Files of the config's folder that it extends or reads, relative to that folder. UsageError where it reads something outside,
/// which a copy elsewhere would look for in vain.
std::vector<std::filesystem::path> companions(const Example& example);

}  // namespace binnacle::command
