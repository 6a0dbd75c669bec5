// SPDX-License-Identifier: Apache-2.0
// Where the command lies, built or installed, and what lies with it.
#pragma once

#include <filesystem>

namespace binnacle::command {

/// The folder of this program, and with it the command and its modules.
std::filesystem::path program_folder();

/// PREFIX of PREFIX/bin/binnacle.
std::filesystem::path prefix();

/// PREFIX/share/binnacle/FOLDER; UsageError where it is missing: "the WHAT are missing: …".
std::filesystem::path shared_folder(const std::filesystem::path& folder, const char* what);

}  // namespace binnacle::command
