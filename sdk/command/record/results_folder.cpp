// SPDX-License-Identifier: Apache-2.0
#include "results_folder.hpp"

#include <stdexcept>
#include <utility>

#include "output.hpp"

namespace binnacle::command {

results::Results read_results(const std::filesystem::path& folder) {
  try {
    return results::read(folder);
  } catch (const std::runtime_error& error) {
    throw OutputError(error.what());
  }
}

results::RunResults read_run(const std::filesystem::path& folder) {
  auto results = read_results(folder);
  if (!results.run)
    throw OutputError("'" + folder.string() +
                      "' holds a study alone, and no run; make one with 'binnacle run CONFIG --out " + folder.string() +
                      "'");
  return std::move(*results.run);
}

}  // namespace binnacle::command
