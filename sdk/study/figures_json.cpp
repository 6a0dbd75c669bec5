// SPDX-License-Identifier: Apache-2.0
#include "figures_json.hpp"

#include <algorithm>
#include <array>

namespace binnacle::study {

using Json = nlohmann::ordered_json;

namespace {

std::optional<Figures> figures_of(const Json& json, std::size_t metrics) {
  Figures figures;
  if (json.is_string()) {
    figures.state = Figures::State::failed;
    figures.failure = json.get<std::string>();
    return figures;
  }
  // The verdict's name stands behind the values.
  constexpr std::array verdicts{Verdict::ok, Verdict::doubtful, Verdict::lost};
  if (!json.is_array() || json.size() != metrics + 1) return std::nullopt;
  const auto verdict =
      std::ranges::find_if(verdicts, [&](Verdict candidate) { return json.back() == verdict_name(candidate); });
  if (verdict == verdicts.end()) return std::nullopt;
  figures.verdict = *verdict;
  const auto number = [](const Json& value) { return value.is_number() ? value.get<double>() : std::nan(""); };
  for (std::size_t m = 0; m < metrics; ++m) {
    const Json& value = json[m];
    if (!value.is_array() || value.size() != 3) return std::nullopt;
    figures.values.push_back({number(value[0]), number(value[1]), number(value[2])});
  }
  figures.state = Figures::State::finished;
  return figures;
}

}  // namespace

Json entry_of(RunKey key, const Figures& figures) {
  Json entry = Json::array({key.variant, key.run});
  if (figures.state == Figures::State::failed) {
    entry.push_back(figures.failure);
    return entry;
  }
  Json values = Json::array();
  for (const auto& value : figures.values) values.push_back({value.value, value.dof, value.n});  // NaN becomes null
  values.push_back(verdict_name(figures.verdict));
  entry.push_back(std::move(values));
  return entry;
}

std::optional<std::pair<RunKey, Figures>> read_entry(const Json& entry, std::size_t metrics) {
  if (!entry.is_array() || entry.size() != 3 || !entry[0].is_number_unsigned() || !entry[1].is_number_unsigned())
    return std::nullopt;
  auto figures = figures_of(entry[2], metrics);
  if (!figures) return std::nullopt;
  return std::pair(RunKey{entry[0].get<std::size_t>(), entry[1].get<std::size_t>()}, std::move(*figures));
}

std::string line_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace binnacle::study
