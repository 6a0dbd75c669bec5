// SPDX-License-Identifier: Apache-2.0
#include "smoothers.hpp"

#include "output.hpp"
#include "score/sections.hpp"

namespace binnacle::command {

void add_smoothers(const std::filesystem::path& config, LoadOptions& options) {
  const Json filters = Json::parse(score::load_config(config, options).text()).value("filters", Json());
  for (const auto& [name, filter] : filters.items())
    if (filter.is_object() && !filter.contains("smoother"))
      options.sets.push_back("/filters/" + name + "/smoother=\"fixed_interval\"");
}

}  // namespace binnacle::command
