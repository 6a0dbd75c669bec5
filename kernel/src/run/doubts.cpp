// SPDX-License-Identifier: Apache-2.0
// The reasons against a filter's estimates as a user reads them.
#include <cmath>
#include <cstdio>

#include "binnacle/session.hpp"
#include "run/runtime.hpp"

namespace binnacle {

namespace {

std::string number(double value) {
  char text[32];
  const bool is_count = value == std::floor(value) && value < 1e15;
  std::snprintf(text, sizeof text, is_count ? "%.0f" : "%.3g", value);
  return text;
}

std::string since(const TrustReason& reason) {
  char text[48];
  std::snprintf(text, sizeof text, "%.1f s", seconds(reason.since));
  return text;
}

/// "once", "7 times".
std::string times(const TrustReason& reason) { return reason.figure == 1 ? "once" : number(reason.figure) + " times"; }

/// "'fix'", or "'fix', row velocity 2".
std::string subject(const TrustReason& reason, const MeasurementInfo& measurement) {
  std::string text = "'" + measurement.name + "'";
  if (reason.group < 0) return text;
  return text + ", row " + measurement.groups[internal::base::as_size(reason.group)].name + " " +
         std::to_string(reason.key);
}

/// "velocity.x", of a row of P.
std::string component_name(const FilterInfo& filter, int row) {
  for (const auto& block : filter.blocks) {
    const int active = internal::base::count_of(block.active), own = row - block.first_row;
    if (own >= 0 && own < active)
      return block.name + "." +
             block.declaration->error[internal::base::as_size(block.active[internal::base::as_size(own)])].name;
  }
  return "";
}

/// Of a reason against the filter as a whole; empty: it is one against a measurement. `last_refusal`: why the newest refused
/// sample was.
std::string text_of_filter(const TrustReason& reason, const FilterInfo& filter, const std::string& last_refusal) {
  const std::string figure = number(reason.figure), limit = number(reason.limit);
  if (reason.doubt == Doubt::bridged)
    return "the input of '" + filter.name + "' has a hole of " + figure + " s at " + since(reason) + " (limit " +
           limit + " s); the motion of the vehicle in it is unknown";
  if (reason.doubt == Doubt::frozen && reason.measurement < 0)
    return "the input of '" + filter.name + "' repeats the same numbers for " + figure + " s from " + since(reason) +
           " on (limit " + limit + " s): the sensor hangs";
  if (reason.doubt == Doubt::unaided)
    return "no sample of any measurement of '" + filter.name + "' was used: " +
           (last_refusal.empty() ? "channels, or their spans of time, are not those of the driving input"
                                 : "the last was refused because " + last_refusal);
  if (reason.doubt == Doubt::restarted)
    return "'" + filter.name + "' started anew " + times(reason) + ", first at " + since(reason) +
           (reason.limit > 0 ? ", after a hole of " + limit + " s in its input" : ": its earlier estimates were wrong");
  if (reason.doubt == Doubt::input_ended)
    return "the input of '" + filter.name + "' ended at " + since(reason) + ", " + figure +
           " s before the newest sample (limit " + limit + " s)";
  if (reason.doubt == Doubt::stopped)
    return "'" + filter.name + "' stopped at " + since(reason) + ": the input has a hole of " + figure +
           " s (longest_bridge " + limit + " s), and no initial values came after it";
  if (reason.doubt == Doubt::lagging)
    return "live estimates of '" + filter.name + "' lagged " + figure + " s behind the arrivals, first at " +
           since(reason) + " (history " + limit + " s): the budget of steps is too small; late samples were not used";
  if (reason.doubt == Doubt::indefinite)
    return "P of '" + filter.name + "' is not a covariance, first at " + since(reason) + ": '" +
           component_name(filter, static_cast<int>(reason.key)) + "' has " + figure +
           " of its variance left once other components are known (limit -" + limit +
           "), as of a correlation beyond one; \"covariance\": \"ud\" or \"square_root\" cannot become so by rounding";
  return "";
}

std::string text_of(const TrustReason& reason, const FilterInfo& filter, const std::string& last_refusal) {
  if (const std::string text = text_of_filter(reason, filter, last_refusal); !text.empty()) return text;
  const std::string figure = number(reason.figure), limit = number(reason.limit);
  const std::string who = subject(reason, filter.measurements[internal::base::as_size(reason.measurement)]);
  switch (reason.doubt) {
    case Doubt::locked_out:
      return who + " is locked out: refused " + figure + " times in a row since " + since(reason) + ", up to the end";
    case Doubt::never_accepted:
      return who + " was never accepted: " + figure + " samples, all of them refused, the last because " + last_refusal;
    case Doubt::mostly_refused:
      return who + " was mostly refused: " + number(100 * reason.figure) +
             " % of its rows; the estimate is wrong, or " +
             "clock, axes, units or signs of this measurement are not what the config says";
    case Doubt::nis:
      return who + " has innovations larger than its noise: NIS over rows is " + figure + " in the window from " +
             since(reason) + " (limit " + limit + ")";
    case Doubt::bias:
      return who + " has biased innovations: their mean is " + figure + " of their 1-sigma in the window from " +
             since(reason) + " (limit " + limit + ")";
    case Doubt::correlation:
      return who + " has innovations that are correlated in time: " + figure +
             " of their variance in the window from " + since(reason) + " (limit " + limit + ")";
    case Doubt::recovered:
      return who + " had to be recovered " + times(reason) + ", first at " + since(reason) +
             ": it was refused or biased for a long time" +
             (reason.verdict == Verdict::lost
                  ? "; it contradicted the state by more than 5 sigma, and nothing else does: "
                    "either may be wrong"
                  : "");
    case Doubt::was_locked_out:
      return who + " was locked out for a while: refused " + figure + " times in a row from " + since(reason) + " on";
    case Doubt::frozen:
      return who + " repeats the same numbers: " + figure + " refused samples in a row from " + since(reason) +
             " on; the sensor hangs";
    case Doubt::silent:
      return "no sample of " + who + " was usable for " + figure + " s from " + since(reason) + " on (limit " + limit +
             " s), and the uncertainty of what it observes grew 3 times or more";
    case Doubt::scattered:
      return who + " claims a standard deviation of " + limit + " and scatters by " + figure + ", first seen at " +
             since(reason) + ": its noise was increased";
    case Doubt::unresolved:
      return who + " saw " + figure + " times the variance of its noise at " + since(reason) + " (limit " + limit +
             "): \"covariance\": \"joseph\" has too few digits for this, so the sigmas after it are zero or wrong; "
             "\"ud\" and \"square_root\" have enough";
    case Doubt::indefinite:
    case Doubt::bridged:
    case Doubt::unaided:
    case Doubt::restarted:
    case Doubt::input_ended:
    case Doubt::stopped:
    case Doubt::lagging: break;
  }
  return who;
}

const char* code_of(Doubt doubt) {
  constexpr const char* codes[] = {"B100", "B101", "B102", "B103", "B104", "B105", "B106", "B107", "B108", "B109",
                                   "B110", "B117", "B115", "B118", "B116", "B123", "B126", "B147", "B127"};
  return codes[static_cast<int>(doubt)];
}

}  // namespace

Diagnostics Session::doubts(FilterId filter, Verdict least) const {
  std::vector<TrustReason> reasons(this->reasons(filter, {}));
  this->reasons(filter, reasons);
  const auto& plan = engine(filter).plan();
  const auto& document = composition_->plan().document;
  Diagnostics doubts;
  for (const auto& reason : reasons) {
    if (reason.verdict < least) continue;
    const std::string& pointer =
        reason.measurement < 0 ? plan.pointer : plan.measurements[internal::base::as_size(reason.measurement)].pointer;
    std::string last_refusal;
    for (int m = 0; m < static_cast<int>(plan.measurements.size()); ++m)
      if (reason.measurement == m || (reason.measurement < 0 && last_refusal.empty()))
        last_refusal = engine(filter).ledger().tally(m).last_reason;
    doubts.warning(code_of(reason.doubt), document.key_origin(pointer), pointer,
                   text_of(reason, composition_->filters()[internal::base::as_size(filter.index)], last_refusal));
  }
  return doubts;
}

}  // namespace binnacle
