// SPDX-License-Identifier: Apache-2.0
#include "warnings.hpp"

#include "binnacle/composition.hpp"
#include "covariance/analysis.hpp"
#include "output.hpp"
#include "score/sections.hpp"
#include "study/study.hpp"
#include "tune/plan.hpp"

namespace binnacle::command {

Diagnostics warnings_of(const std::filesystem::path& path, const LoadOptions& options) {
  const Config config = score::load_config(path, options);
  study::StudyOptions study_options;
  study_options.load = options;
  if (tune::is_in(config)) tune::read_plan(path, options);
  if (covariance::is_in(config)) {
    const auto warnings = covariance::load(path, options).warnings();
    return config.contains("/study/metrics") ? study::Study::load(path, study_options).warnings() : warnings;
  }
  if (study::Study::is_in(config)) return study::Study::load(path, study_options).warnings();
  return score::compose(config, options)->warnings();
}

}  // namespace binnacle::command
