// SPDX-License-Identifier: Apache-2.0
// What can be observed in a run, and when.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"
#include "binnacle/step_log.hpp"
#include "binnacle/unit.hpp"
#include "observe/window.hpp"

namespace binnacle::observe {

/// The whole of it.
Window whole_run();
/// "60:90", "start+10 s:", or the name of a window of the config's "evaluate"; ends are seconds of the data, or have a unit, and one
/// that is left out is that of the run. The failure is one line.
Parsed<Window> read_window(const Composition& composition, const std::string& text);

/// Which run.
struct RunKey {
  std::uint64_t seed = 1;
  int run = 0;
  std::function<bool()> goes_on = [] { return true; };  // asked every now and then; false: it stops
};

/// Looks on while the composition runs.
class Observability {
 public:
  Observability(const Composition& composition, const std::vector<Window>& windows);
  /// Null for a filter without rows of P or without measurements.
  StepObserver* step_observer(int filter) const { return watches_[static_cast<std::size_t>(filter)].get(); }

  /// Once the run is over: by filter a list of windows, { "window", "from_s", "to_s", "samples", "components", "singular_values",
  /// "weak", "inconsistent" or "not_checked", "notes" }. Runs the config anew for each window (one_path.hpp); throws as a
  /// run does.
  nlohmann::ordered_json figures(const std::filesystem::path& config, const LoadOptions& options,
                                 const RunKey& key) const;

 private:
  std::vector<std::unique_ptr<FilterWatch>> watches_;
};

}  // namespace binnacle::observe
