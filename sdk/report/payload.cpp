// SPDX-License-Identifier: Apache-2.0
#include "payload.hpp"

#include <utility>

namespace binnacle::report {

namespace {

std::string text_in(const Json& config, const char* key) {
  const auto found = config.find(key);
  return found != config.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace

namespace {

template <class RunPayload>
Json payload_of(const results::Results& results, RunPayload run) {
  const Json none = Json::object();
  const Json& config = results.run ? results.run->config : results.study ? results.study->config : none;
  Json page{{"title", text_in(config, "title")}, {"description", text_in(config, "description")}};
  Columns columns;
  if (results.run) page["run"] = run(columns);
  if (results.study) page["study"] = study_payload(*results.study, columns);
  page["columns"] = std::move(columns).json();
  return page;
}

}  // namespace

Json payload(const results::Results& results, const Limits& limits) {
  return payload_of(results,
                    [&](Columns& columns) { return run_payload(*results.run, limits, Extent::whole, columns); });
}

Json payload(const results::Results& results, const std::vector<const DrawnFilter*>& drawn, const Limits& limits) {
  return payload_of(results, [&](Columns& columns) { return run_payload(*results.run, drawn, limits, columns); });
}

Json thinned_payload(const results::RunResults& run, const char* state, const Limits& limits) {
  Json page{{"live", state},
            {"title", text_in(run.config, "title")},
            {"description", text_in(run.config, "description")}};
  Columns columns;
  page["run"] = run_payload(run, limits, Extent::thinned, columns);
  page["columns"] = std::move(columns).json();
  return page;
}

}  // namespace binnacle::report
