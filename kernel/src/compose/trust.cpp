// SPDX-License-Identifier: Apache-2.0
// The limits of a filter's monitors: "trust".
#include <algorithm>

#include "compose/composer.hpp"

namespace binnacle::internal::compose {

namespace {

bool is_off(const Reader& at) { return at && config::JsonOf::at(at) == false; }

/// Reads a limit; `false` turns its monitor off, which is 0 in the plan.
void read_limit(const Reader& trust, const ParameterSpec& spec, double& limit) {
  limit = is_off(trust[spec.name]) ? 0.0 : trust[spec.name].number(spec).value_or(limit);
}

}  // namespace

/// `"trust": false` turns all of them off.
void FilterComposer::read_trust() {
  const Reader trust = at["trust"];
  if (!trust) return;
  if (is_off(trust)) {
    for (auto& measurement : plan.measurements) measurement.is_watched = false;
    plan.trust.hole = plan.trust.frozen = plan.trust.silent = 0;
    return;
  }
  if (!trust.is_object("'trust'")) return;
  trust.check_keys({"false_alarm", "nis", "bias", "correlation", "beyond_reason", "after", "refused", "hole", "frozen",
                    "silent", "except"},
                   "'trust'");
  TrustPlan& limits = plan.trust;
  read_limit(trust, parameter::number("false_alarm", "1").above(0).below(1), limits.false_alarm);
  read_limit(trust, parameter::number("beyond_reason", "1").above(1), limits.nis);
  read_limit(trust, parameter::number("refused", "1").above(0).below(1), limits.refused);
  for (const auto& [name, is_on] :
       {std::pair{"nis", &limits.tests_nis}, {"bias", &limits.tests_bias}, {"correlation", &limits.tests_correlation}})
    *is_on = trust[name].boolean().value_or(*is_on);
  double after = static_cast<double>(limits.after);
  read_limit(trust, parameter::number("after", "1").at_least(1), after);
  limits.after = static_cast<std::int64_t>(after);
  for (const auto& [name, limit] :
       {std::pair{"hole", &limits.hole}, {"frozen", &limits.frozen}, {"silent", &limits.silent}})
    *limit = is_off(trust[name]) ? 0 : trust[name].time(parameter::time(name).above(0)).value_or(*limit);
  const Reader except = trust["except"];
  for (const auto& name : except.names().value_or(std::vector<std::string>())) {
    const auto found = std::ranges::find(plan.measurements, name, &MeasurementPlan::name);
    if (found != plan.measurements.end()) {
      found->is_watched = false;
      continue;
    }
    if (!is_complete) continue;  // what is not there may be reported already
    const auto names = names_of(plan.measurements);
    except.error("B027", "there is no measurement '" + name + "'" + suggestion(name, names));
  }
}

}  // namespace binnacle::internal::compose
