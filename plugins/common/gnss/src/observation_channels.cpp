// SPDX-License-Identifier: Apache-2.0
#include "gnss/observation_channels.hpp"

#include <algorithm>

#include "binnacle/view.hpp"
#include "gnss/channels.hpp"

namespace binnacle::gnss {

ParameterSpec Signals::parameter() {
  using namespace binnacle::parameter;
  return object("signals", {text("gps").defaults("\"1C\"").about("GPS: L1 C/A is 1C; \"\": none"),
                            text("galileo").defaults("\"\"").about("Galileo: E1 is 1C or 1X; \"\": none"),
                            text("beidou").defaults("\"\"").about("BeiDou: B1I is 2I, in RINEX 3.02 1I; \"\": none")})
      .defaults("{}")
      .about("signal used of each constellation, by its observation code");
}

Signals Signals::of(const Parameters& parameters) {
  const Parameters codes = parameters.object("signals");
  Signals signals{codes.text("gps"), codes.text("galileo"), codes.text("beidou")};
  for (const char* constellation : {"gps", "galileo"}) {
    const std::string& code = codes.text(constellation);
    if (!code.empty() && (code.size() != 2 || code.front() != '1'))
      throw ComponentError("a code has two characters and begins with 1, the frequency: \"1C\"; found '" + code + "'",
                           std::string("/signals/") + constellation);
  }
  if (!signals.beidou.empty() && signals.beidou != "2I" && signals.beidou != "1I")
    throw ComponentError(
        "of BeiDou B1I is read, \"2I\" (in RINEX 3.02 \"1I\"): its messages' clock and group delay are for it; "
        "found '" +
            signals.beidou + "'",
        "/signals/beidou");
  if (signals.gps.empty() && signals.galileo.empty() && signals.beidou.empty())
    throw ComponentError("no signal is taken", "/signals");
  return signals;
}

void ObservationChannels::declare(const Signals& signals, SourceDeclaration& declaration) {
  int rows = 0;
  for (const Constellation constellation : constellations())
    if (!signals.of(constellation).empty()) rows += most_satellites(constellation);
  ChannelDeclaration obs("obs"), ephemeris("ephemeris", ephemeris_fields()), iono("iono");
  const auto fields = observation_fields(false);
  satellite_ = obs.carries_per_row(fields[observation::satellite]);
  pseudorange_ = obs.carries_per_row(fields[observation::pseudorange]);
  range_rate_ = obs.carries_per_row(fields[observation::range_rate]);
  cn0_ = obs.carries_per_row(fields[observation::cn0]);
  event_ = obs.carries(field::level("event", "1").about("1: power failure since the epoch before"));
  clock_offset_ =
      obs.carries(field::level("clock_offset", "s").about("of the receiver, as the file gives it; NaN: it does not"));
  clock_jump_ = obs.carries(field::level("clock_jump", "m")
                                .about("the receiver's clock was set by it since the epoch before; found from code and "
                                       "phase"));
  obs.max_rows = ephemeris.max_rows = rows;
  const auto k = klobuchar_fields();
  alpha_ = iono.carries(k[0], k[1], k[2], k[3]);
  beta_ = iono.carries(k[4], k[5], k[6], k[7]);
  obs_ = declaration.emits(std::move(obs));
  ephemeris_ = declaration.emits(std::move(ephemeris));
  iono_ = declaration.emits(std::move(iono));
}

void ObservationChannels::write(const ObservationEpoch& epoch, SourceOutput& output) const {
  SampleWriter& out = output.on(obs_);
  out.t = epoch.t;
  out[event_] = epoch.event;
  out[clock_offset_] = epoch.clock_offset;
  out[clock_jump_] = epoch.clock_jump;
  for (const Observation& observation : epoch.satellites) {
    const int row = out.rows++;
    out(row, satellite_) = static_cast<double>(observation.satellite);
    out(row, pseudorange_) = observation.pseudorange;
    out(row, range_rate_) = observation.range_rate;
    out(row, cn0_) = observation.cn0;
  }
}

void ObservationChannels::write(const MessageSet& set, const std::vector<BroadcastMessage>& messages,
                                SourceOutput& output) const {
  SampleWriter& out = output.on(ephemeris_);
  out.t = set.t;
  for (const std::size_t message : set.messages)
    write_ephemeris(messages[message].ephemeris, out.row_view(out.rows++).data());
}

void ObservationChannels::write(const Klobuchar& klobuchar, Time t, SourceOutput& output) const {
  SampleWriter& out = output.on(iono_);
  out.t = t;
  out[alpha_] = vector_at<4>(klobuchar.alpha);
  out[beta_] = vector_at<4>(klobuchar.beta);
}

void Orphans::add(const ObservationEpoch& epoch, const MessageSet* set, const std::vector<BroadcastMessage>& messages) {
  for (const Observation& observation : epoch.satellites) {
    const bool has_message = set && std::any_of(set->messages.begin(), set->messages.end(), [&](std::size_t i) {
                               return messages[i].ephemeris.satellite == observation.satellite;
                             });
    if (has_message) continue;
    if (missing_.empty()) first_line_ = epoch.line;
    ++missing_[observation.satellite];
  }
}

std::string Orphans::text() const {
  if (missing_.empty()) return {};
  std::string message = "no usable broadcast message for";
  for (const auto& [satellite, count] : missing_)
    message += " " + satellite_name(satellite) + " (" + std::to_string(count) + " epochs)";
  return message;
}

}  // namespace binnacle::gnss
