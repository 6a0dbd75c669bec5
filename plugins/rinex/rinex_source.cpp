// SPDX-License-Identifier: Apache-2.0
// The rinex source: recorded observations and broadcast messages as channels.
#include "rinex_source.hpp"

#include <algorithm>
#include <iterator>

#include "binnacle/parameters.hpp"
#include "header.hpp"

namespace binnacle::rinex {

ComponentSpec RinexSource::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "rinex";
  spec.summary = "recorded GNSS observations and broadcast messages in RINEX 2 and 3, plain or gzipped";
  spec.source = "RINEX 2.11 (2007), RINEX 3.04 (2018); IS-GPS-200; Galileo OS SIS ICD; BDS-SIS-ICD-B1I-3.0";
  spec.parameters = {
      path("observations").about("observation file; without it only messages are emitted"),
      path("navigation").about("navigation message file"),
      gnss::Signals::parameter(),
      parameter::integer("week").at_least(0).at_most(9999).defaults("0").about(
          "GPS week at whose start time is zero; 0: seconds since 1980-01-06"),
      list("window", time("time")).about("[from, to]; only epochs inside are emitted"),
      choice("invalid_records", {"skip", "error"})
          .defaults("\"skip\"")
          .about("skip: skip and report records that cannot be read; error: stop at the first one"),
  };
  const auto rules = gnss::ChoiceRules::parameters();
  spec.parameters.insert(std::next(spec.parameters.begin(), 3), rules.begin(), rules.end());
  spec.example =
      R"json({"observations": "site.obs", "navigation": "site.nav", "week": 1316, "choose": "nearest_toe"})json";
  spec.surroundings = R"json({"files": {
"site.obs": "     2.10           OBSERVATION DATA    G (GPS)             RINEX VERSION / TYPE\n     1    C1                                                # / TYPES OF OBSERV \n                                                            END OF HEADER       \n 05  4  2  0  0  0.0000000  0  1G 1\n  25666732.384\n 05  4  2  0  0 30.0000000  0  1G 1\n  25666733.384\n",
"site.nav": "     2.10           N: GPS NAV DATA                         RINEX VERSION / TYPE\n    1.1180D-08  1.4900D-08 -5.9600D-08 -5.9600D-08          ION ALPHA           \n    8.8060D+04  1.6380D+04 -1.9660D+05 -1.3110D+05          ION BETA            \n                                                            END OF HEADER       \n 1 05  4  2  2  0  0.0 3.966595977540D-04 1.705302565820D-12 0.000000000000D+00\n    1.400000000000D+02-5.218750000000D+01 4.026596389650D-09 2.871534990340D+00\n   -2.676621079440D-06 5.957618006510D-03 4.174187779430D-06 5.153636478420D+03\n    5.256000000000D+05 1.061707735060D-07-2.493184817740D+00-9.313225746150D-08\n    9.833919144490D-01 3.093750000000D+02-1.650496813270D+00-7.889971342930D-09\n   -8.571785642400D-12 1.000000000000D+00 1.316000000000D+03 0.000000000000D+00\n    2.000000000000D+00 0.000000000000D+00-3.259629011150D-09 1.400000000000D+02\n    5.184000000000D+05 4.000000000000D+00 0.000000000000D+00 0.000000000000D+00\n"}})json";
  return spec;
}

RinexSource::RinexSource(const Binding& binding)
    : from_(std::numeric_limits<Time>::min()), to_(std::numeric_limits<Time>::max()) {
  const Parameters& parameters = binding.parameters();
  if (parameters.has("observations")) observation_path_ = parameters.text("observations");
  if (parameters.has("navigation")) navigation_path_ = parameters.text("navigation");
  if (observation_path_.empty() && navigation_path_.empty())
    throw ComponentError("there is no file: give 'observations', 'navigation', or both");
  signals_ = gnss::Signals::of(parameters);
  rules_ = gnss::ChoiceRules::of(parameters);
  origin_week_ = static_cast<int>(parameters.integer("week"));
  on_invalid_ = parameters.text("invalid_records") == "error" ? OnInvalid::error : OnInvalid::skip;
  if (parameters.has("window")) {
    const auto& window = parameters.list("window");
    if (window.size() != 2 || window[0].integer >= window[1].integer)
      throw ComponentError("a window is [from, to] with from < to", "/window");
    from_ = window[0].integer;
    to_ = window[1].integer;
  }
  if (!observation_path_.empty()) check_file(observation_path_, FileType::observation);
  if (!navigation_path_.empty()) check_file(navigation_path_, FileType::navigation);

  channels_.declare(signals_, declaration_);
  next_ = declaration_.keeps<std::uint64_t>();
}

void RinexSource::open(Reporter& reporter) {
  Faults of_observations(observation_path_, on_invalid_, reporter);
  Faults of_navigation(navigation_path_, on_invalid_, reporter);
  if (!navigation_path_.empty()) {
    navigation_ = read_navigation(navigation_path_, origin_week_, of_navigation);
    std::erase_if(navigation_.messages, [this](const Message& m) { return !signals_.takes(m.ephemeris.satellite); });
    if (navigation_.messages.empty())
      of_navigation.note("B066", 0, "contains no broadcast message of the requested signals");
  }
  if (!observation_path_.empty()) {
    epochs_ = read_observations(observation_path_, origin_week_, signals_, of_observations);
    const std::size_t read = epochs_.size();
    std::erase_if(epochs_, [this](const Epoch& epoch) { return epoch.t < from_ || epoch.t > to_; });
    if (epochs_.empty()) {
      of_observations.report();
      throw ComponentError::in_data(read == 0 ? "no epoch after the header" : "no epoch in the window",
                                    observation_path_, 0, "B066");
    }
  }
  Time first = from_, last = to_;
  if (!epochs_.empty()) {
    first = epochs_.front().t;
    last = epochs_.back().t;
  } else {
    Time earliest = std::numeric_limits<Time>::max();
    for (const Message& message : navigation_.messages)
      earliest =
          std::min(earliest, rules_.choice == gnss::Choice::upload ? message.uploaded : message.toe - rules_.max_age);
    first = std::max(first, earliest);
  }
  arrange(first, last);
  if (!epochs_.empty() && !navigation_path_.empty()) report_orphans(of_observations);
  of_navigation.report();
  of_observations.report();
}

/// At one instant coefficients and messages come before the observations that need them.
void RinexSource::arrange(Time first, Time last) {
  if (!navigation_.messages.empty() && first <= last) {
    if (navigation_.klobuchar) events_.push_back({first, Kind::klobuchar, 0});
    sets_ = gnss::choose_messages(navigation_.messages, rules_, first, last);
    for (std::size_t i = 0; i < sets_.size(); ++i) events_.push_back({sets_[i].t, Kind::ephemerides, i});
  }
  for (std::size_t i = 0; i < epochs_.size(); ++i) events_.push_back({epochs_[i].t, Kind::observations, i});
  std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) { return a.t < b.t; });
}

void RinexSource::report_orphans(Faults& faults) const {
  gnss::Orphans orphans;
  const gnss::MessageSet* set = nullptr;
  for (const Event& event : events_) {
    if (event.kind == Kind::ephemerides) set = &sets_[event.index];
    if (event.kind == Kind::observations) orphans.add(epochs_[event.index], set, navigation_.messages);
  }
  if (const std::string text = orphans.text(); !text.empty()) faults.note("B065", orphans.first_line(), text);
}

SourceStatus RinexSource::next(const MemoryView& bytes, SourceOutput& output) const {
  std::uint64_t& at = bytes[next_];
  if (at >= events_.size()) return SourceStatus::end;
  const Event& event = events_[static_cast<std::size_t>(at++)];
  switch (event.kind) {
    case Kind::klobuchar: channels_.write(*navigation_.klobuchar, event.t, output); break;
    case Kind::ephemerides: channels_.write(sets_[event.index], navigation_.messages, output); break;
    case Kind::observations: channels_.write(epochs_[event.index], output); break;
  }
  return SourceStatus::sample;
}

}  // namespace binnacle::rinex
