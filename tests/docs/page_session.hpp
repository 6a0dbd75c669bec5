// SPDX-License-Identifier: Apache-2.0
// A page of the manual as a session at a terminal: all that it says to type, in order, in one shell.
#pragma once

#include <string>
#include <vector>

#include "document.hpp"

namespace binnacle::test {

struct SessionResult {
  std::vector<std::string> faults;   // empty where the page is true
  std::vector<std::string> untried;  // commands on recorded data that are not there
};

/// Types the page. `sh` fences must exit with 0, or as `# exit status N` behind the line says. What a `text` fence shows
/// after its lines "$ …" must be printed, times aside. A `json` fence that begins with "// NAME.json:" becomes that file.
SessionResult session_of(const MarkdownFile& page);

/// How many commands the page has.
int commands_in(const MarkdownFile& page);

}  // namespace binnacle::test
