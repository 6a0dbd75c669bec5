// SPDX-License-Identifier: Apache-2.0
// Commands in pages that no session types, because another test does.
#pragma once

#include <regex>
#include <string>
#include <vector>

namespace binnacle::test {

struct TypedElsewhere {
  std::string pattern;  // how the command begins, a regular expression
  std::string test;     // a file of the project: the test that types it
  std::string words;    // a part of that file that shows it
};

const std::vector<TypedElsewhere>& typed_elsewhere();

/// The entry for a command, or nullptr: then a session types it.
const TypedElsewhere* typed_elsewhere(const std::string& command);

}  // namespace binnacle::test
