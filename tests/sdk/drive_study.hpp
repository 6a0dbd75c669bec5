// SPDX-License-Identifier: Apache-2.0
// A study with random errors, and how what several of them left is compared.
#pragma once

#include <string>

#include "workbench.hpp"

namespace binnacle::test {

/// drive.json: half a minute of the quickstart's drive, 6 runs of 4 variants; a filter that trusts its fixes too much or
/// too little.
void write_drive(const Workbench& bench);

/// Byte for byte.
void check_same_files(const Workbench& bench, const std::string& a, const std::string& b);

/// 0 where there is no such file.
std::size_t lines_in(const std::string& path);

}  // namespace binnacle::test
