// SPDX-License-Identifier: Apache-2.0
#include "provenance.hpp"
#include "read_files.hpp"

namespace binnacle::results {

StudyResults read_study(const nc::File& file) {
  StudyResults study;
  const nc::Group root = file.root();
  read_provenance(root, "study", study.config, study.provenance);
  const auto variants = root.variable("variant"), runs = root.variable("run");
  if (!variants || !runs) throw nc::Failure("it has no variable 'variant' or 'run'");
  study.variants = root.read_texts(*variants);
  if (root.shape(*runs).size() != 1) throw nc::Failure("its variable 'run' has another shape than (run)");
  study.runs = root.read<std::int64_t>(*runs).size();
  std::vector<std::vector<double>> values;
  for (int variable = 0; variable < root.variables(); ++variable) {
    if (!root.has(variable, "metric")) continue;
    const std::string si = root.text(variable, "units"), shown = root.text(variable, "display_units");
    study.metrics.push_back({root.text(variable, "metric"), shown.empty() ? si : shown, si});
    values.push_back(root.read<double>(variable));
    const std::size_t count = values.back().size();
    if (study.runs == 0 ? count > 0 : count % study.runs != 0 || count / study.runs != study.variants.size())
      throw nc::Failure("its variable '" + root.variable_name(variable) + "' has another shape than variants and runs");
  }
  for (std::size_t v = 0; v < study.variants.size(); ++v)
    for (const auto& metric : values)
      study.values.insert(study.values.end(), metric.begin() + static_cast<std::ptrdiff_t>(v * study.runs),
                          metric.begin() + static_cast<std::ptrdiff_t>((v + 1) * study.runs));
  return study;
}

}  // namespace binnacle::results
