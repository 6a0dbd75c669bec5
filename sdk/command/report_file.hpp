// SPDX-License-Identifier: Apache-2.0
// The report of a folder of results, as a file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace binnacle::command {

/// Where run and study put it.
std::filesystem::path report_in(const std::filesystem::path& folder);

/// Reads what `run` or `study` left in the folder and writes its page; returns the page's bytes. Throws OutputError
/// where results are missing or damaged, UsageError where the page cannot be made there.
std::size_t write_report(const std::filesystem::path& folder, const std::filesystem::path& page);

/// The whole page at its place; returns its bytes.
std::size_t write_page(const std::string& text, const std::filesystem::path& page);

}  // namespace binnacle::command
