// SPDX-License-Identifier: Apache-2.0
// The limits of a filter's monitors: "trust".
#include <algorithm>

#include "compose/composer.hpp"

namespace binnacle::internal::compose {

namespace {

bool is_off(const Reader& at) { return at && config::JsonOf::at(at) == false; }

/// Reads a limit; `false` turns its monitor off, which is 0 in the plan.
void read_limit(const Reader& trust, const ParameterSpec& spec, double& limit) {
  const Reader at = trust[spec.name];
  if (!at) return;
  limit = is_off(at) ? 0.0 : at.number(spec).value_or(limit);
}

void read_switch(const Reader& at, bool& is_on) { is_on = at.boolean().value_or(is_on); }

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
  read_switch(trust["nis"], limits.tests_nis);
  read_switch(trust["bias"], limits.tests_bias);
  read_switch(trust["correlation"], limits.tests_correlation);
  double after = static_cast<double>(limits.after);
  read_limit(trust, parameter::number("after", "1").at_least(1), after);
  limits.after = static_cast<std::int64_t>(after);
  const auto read_time = [&](const char* name, Time& limit) {
    double length = seconds(limit);
    read_limit(trust, parameter::number(name, "s").above(0), length);
    limit = nanoseconds(length);
  };
  read_time("hole", limits.hole);
  read_time("frozen", limits.frozen);
  read_time("silent", limits.silent);
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
