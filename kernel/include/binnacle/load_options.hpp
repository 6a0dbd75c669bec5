// SPDX-License-Identifier: Apache-2.0
// What the command line adds to a config.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace binnacle {

struct LoadOptions {
  std::map<std::string, std::string> vars;  ///< --var name=value; replaces what the config's "vars" says
  std::vector<std::string> sets;            ///< --set PTR=V, in order
  /// JSON pointers to objects of the config, each merged over the whole of it (RFC 7386) before `sets`.
  std::vector<std::string> patches = {};
};

}  // namespace binnacle
