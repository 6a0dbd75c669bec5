// SPDX-License-Identifier: Apache-2.0
// new filter: a config of one's own, copied from an example.
#pragma once

#include <string>

namespace binnacle::command {

struct NewFilter {
  std::string name;                     // of the file, with or without ".json"
  std::string from = "loose-ins-gnss";  // an example, or a config's path
  std::string folder = ".";
  bool json = false;
};

/// NAME.json, and beside it what the example reads. Returns the exit status; UsageError leaves nothing behind.
int make_filter(const NewFilter& wanted);

/// What there is to copy.
int list_examples(bool json);

}  // namespace binnacle::command
