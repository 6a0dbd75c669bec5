// SPDX-License-Identifier: Apache-2.0
// What the command line adds to a config.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace binnacle {

class Section;

struct LoadOptions {
  std::map<std::string, std::string> vars;  ///< --var name=value; replaces what the config's "vars" says
  std::vector<std::string> sets;            ///< --set PTR=V, in order
  /// JSON pointers to objects of the config, each merged over the whole of it (RFC 7386) before `sets`.
  std::vector<std::string> patches = {};
  /// Readers of the sections that are not the kernel's. With none, sections that the kernel does not know are left alone,
  /// unless one looks like a misspelt key of the kernel's; with some, a key that is nobody's is an error.
  std::vector<std::shared_ptr<const Section>> sections = {};
};

}  // namespace binnacle
