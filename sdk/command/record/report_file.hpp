// SPDX-License-Identifier: Apache-2.0
// The report of a folder of results, as a file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace binnacle::command {

/// Where run and study put it.
std::filesystem::path report_in(const std::filesystem::path& folder);

/// Of what `run` or `study` left in the folder. Throws OutputError where results are missing or damaged.
std::string report_page(const std::filesystem::path& folder);

/// The whole page at its place; returns its bytes. Throws OutputError, and UsageError where it cannot be made there.
std::size_t write_page(const std::string& text, const std::filesystem::path& page);

}  // namespace binnacle::command
