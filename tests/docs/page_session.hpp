// SPDX-License-Identifier: Apache-2.0
// A page of the manual as a session at a terminal: all that it says to type, in order, in one shell.
#pragma once

#include <string>
#include <vector>

#include "document.hpp"

namespace binnacle::test {

/// What went wrong; empty where the page is true. `sh` fences must exit with 0, or as `# exit status N` behind the
/// line says. What a `text` fence shows after its lines "$ …" must be printed, times aside. A `json` fence that begins
/// with "// NAME.json:" becomes that file. Commands on recorded data and verbs that the program does not have are
/// skipped, and a line says so.
std::vector<std::string> faults_of_session(const MarkdownFile& page);

/// How many commands the page has.
int commands_in(const MarkdownFile& page);

}  // namespace binnacle::test
