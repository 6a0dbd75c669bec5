// SPDX-License-Identifier: Apache-2.0
#include "report_file.hpp"

#include "atomic_file.hpp"
#include "report/page.hpp"
#include "results_folder.hpp"

namespace binnacle::command {

std::filesystem::path report_in(const std::filesystem::path& folder) { return folder / "report.html"; }

std::string report_page(const std::filesystem::path& folder) { return report::page(read_results(folder)); }

std::size_t write_page(const std::string& text, const std::filesystem::path& page) {
  AtomicFile file(page);
  file.write(text);
  file.commit();
  return text.size();
}

}  // namespace binnacle::command
