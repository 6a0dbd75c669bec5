// SPDX-License-Identifier: Apache-2.0
#include "study_results.hpp"

#include "provenance.hpp"

namespace binnacle::command {

results::StudyResults study_results(const study::Study& study, const study::Results& results, const Json& figures,
                                    const Json& config, const std::string& command) {
  results::StudyResults all;
  all.figures = figures;
  all.config = config;
  all.provenance = provenance(study.variants().front().composition->catalog(), command);
  all.provenance["seed"] = study.seed();
  all.runs = results.runs();
  for (const auto& metric : study.metrics()) all.metrics.push_back({metric.name, metric.unit, metric.si_unit});
  for (std::size_t v = 0; v < study.variants().size(); ++v) {
    all.variants.push_back(study.variants()[v].name);
    for (std::size_t m = 0; m < study.metrics().size(); ++m)
      for (std::size_t run = 0; run < results.runs(); ++run) {
        const auto& of_run = results.at(v, run);
        const bool is_there = of_run.state == study::Figures::State::finished;
        all.values.push_back(is_there ? of_run.values[m].value : std::nan(""));
      }
  }
  return all;
}

}  // namespace binnacle::command
