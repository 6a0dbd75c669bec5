// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <utility>

#include "payload.hpp"

namespace binnacle::report {

namespace {

std::string page_name(const NamedRun& run, const std::string& filter) { return run.name + ": " + filter; }

/// Where the first geographic track of all begins, so that all lie on one map.
std::optional<TrackOrigin> common_origin(const std::vector<NamedRun>& runs) {
  for (const auto& [name, folder, run] : runs)
    for (const auto& filter : run.filters)
      if (const auto track = track_of(filter); track && track->lat == track->lat)
        return TrackOrigin{track->lat, track->lon};
  return {};
}

/// What the page calls each filter of each run; null where a run has none.
Json keys_of(const std::vector<NamedRun>& runs, const Json& filters) {
  Json keys = Json::array();
  for (const auto& filter : filters) {
    Json of = Json::array();
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const Json& name = filter.at("of").at(i);
      of.push_back(name.is_null() ? Json(nullptr) : Json(page_name(runs[i], name.get<std::string>())));
    }
    keys.push_back(std::move(of));
  }
  return keys;
}

}  // namespace

Json comparison_payload(const std::vector<NamedRun>& runs, const Json& comparison, const Limits& limits) {
  std::string title;
  for (const auto& run : runs) title += (title.empty() ? "" : ", ") + run.name;
  Json page{{"title", title}, {"description", ""}, {"comparison", comparison}};
  page["comparison"]["keys"] = keys_of(runs, comparison.at("filters"));
  Limits share = limits;
  share.numbers /= std::max<std::size_t>(1, runs.size());
  const auto origin = common_origin(runs);
  Columns columns;
  Json all{{"summary", {{"filters", Json::object()}}}, {"provenance", Json::object()}, {"filters", Json::array()}};
  for (const auto& run : runs) {
    Json of = run_payload(run.run, share, Extent::whole, columns, origin);
    for (auto& filter : of["filters"]) {
      const std::string name = filter["name"].get<std::string>();
      filter["name"] = page_name(run, name);
      if (of["summary"].contains("filters") && of["summary"]["filters"].contains(name))
        all["summary"]["filters"][page_name(run, name)] = of["summary"]["filters"][name];
      all["filters"].push_back(std::move(filter));
    }
  }
  page["run"] = std::move(all);
  page["columns"] = std::move(columns).json();
  return page;
}

}  // namespace binnacle::report
