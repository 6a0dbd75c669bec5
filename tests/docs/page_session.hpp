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

/// Types the page, but for what typed_elsewhere.hpp lists, and for a study that the README of its config types. `sh` fences
/// must exit with 0, or as `# exit status N` behind the line says; a row `| …` of a table that they print must be in the
/// page. What a `text` fence shows after its lines "$ …" must be printed, times aside, and with FOLDER for the folder in
/// which it is typed. A `json` fence that begins with "// NAME.json:" becomes that file.
///
/// What would take minutes is typed in short, and CONTRIBUTING.md says so: in an `sh` fence, `binnacle study configs/…` with
/// `--runs 1`; it, `covariance` and `tune` are stopped after ten seconds and must not have failed by then. Of a config that
/// the page makes itself, they are typed as they stand.
SessionResult session_of(const MarkdownFile& page);

/// A `text` fence that begins with a command behind "$ ".
bool is_shown(const Fence& fence);
/// The commands of the page, without those of fences that are part of a file: that file is run.
std::vector<std::string> commands_in(const MarkdownFile& page);

}  // namespace binnacle::test
