// SPDX-License-Identifier: Apache-2.0
#include "ublox_source.hpp"

#include <algorithm>
#include <iterator>

#include "binnacle/parameters.hpp"

namespace binnacle::ublox {

ComponentSpec UbloxSource::spec() {
  using namespace parameter;
  ComponentSpec spec;
  spec.type = "ublox";
  spec.summary =
      "positions, velocities, baselines, sensor data, pseudoranges and ephemerides from UBX messages of a u-blox "
      "receiver";
  spec.source =
      "u-blox M8 protocol specification (UBX-13003221), ZED-F9P (UBX-18010854) and ZED-F9R (UBX-19056845) interface "
      "descriptions; IS-GPS-200; Galileo OS SIS ICD";
  spec.parameters = {
      path("path").about("complete file of messages, plain or gzipped; alternative to 'from'"),
      list("messages", text("message"))
          .about("messages to be read, for example \"NAV-PVT\", \"RXM-RAWX\"; default: all known messages"),
      gnss::Signals::parameter(),
      time("raw_tick")
          .above(0)
          .defaults("3.90625e-5")
          .about("unit of the time tags of ESF-RAW, which u-blox does not document"),
      time("sensor_shift")
          .defaults("0")
          .about("offset added to the times of ESF-MEAS and ESF-RAW, which are early by the receiver's latency")};
  for (ParameterSpec& each : gnss::ChoiceRules::parameters()) spec.parameters.push_back(std::move(each));
  for (ParameterSpec& each : line_input::Bytes::parameters("a message")) spec.parameters.push_back(std::move(each));
  for (ParameterSpec& each : civil_time::UtcClock::parameters()) spec.parameters.push_back(std::move(each));
  spec.example = R"json({"path": "log.ubx", "messages": ["NAV-PVT"], "week": 2381})json";
  spec.surroundings =
      R"json({"files": {"log.ubx": {"hex": "b56201075c00005a5b18e907081c111e1607190000000000000003010011cfd053c10445e617101c18009b6f18000e0000000a000000dc0500003cf6ffff2c010000630b0000f83bcb014600000087d612007b0000000000000000000000000000001109b56201075c00e85d5b18e907081c111e1707190000000000000003010011cfd053c10445e617101c18009b6f18000e0000000a000000dc0500003cf6ffff2c010000630b0000f83bcb014600000087d612007b000000000000000000000000000000fdcc"}}})json";
  return spec;
}

UbloxSource::UbloxSource(const Binding& binding)
    : rules_{{{}, {}, civil_time::UtcClock(binding.parameters()), 0, 0}, {}, false, {}} {
  const Parameters& p = binding.parameters();
  rules_.decoder.signals = gnss::Signals::of(p);
  if (!rules_.decoder.signals.beidou.empty())
    throw ComponentError("of BeiDou neither observations nor messages are read; leave it \"\"", "/signals/beidou");
  rules_.decoder.raw_tick = p.time("raw_tick");
  rules_.decoder.sensor_shift = p.time("sensor_shift");
  rules_.messages = gnss::ChoiceRules::of(p);
  rules_.stops_on_error = p.text("on_error") == "stop";
  choose_messages(p);
  declare_channels();
  declaration_.live = line_input::is_live(p);
  if (declaration_.live)
    live_ = std::make_unique<LiveMessages>(p, rules_);
  else
    path_ = line_input::existing_path(p);
}

/// Orbits are computed from GPS time, so that channels which count UTC can have none.
void UbloxSource::choose_messages(const Parameters& p) {
  const auto is_of_satellites = [](int type) { return type == rxm_rawx || type == rxm_sfrbx; };
  std::vector<std::string> names = message_names();
  const auto known = names;
  if (p.has("messages")) {
    names.clear();
    std::size_t i = 0;
    for (const auto& each : p.list("messages")) {
      const std::string place = "/messages/" + std::to_string(i++);
      if (std::find(known.begin(), known.end(), each.text) == known.end()) {
        std::string all;
        for (const auto& name : known) all += (all.empty() ? "" : ", ") + name;
        throw ComponentError("'" + each.text + "' is not a message that is read; expected one of " + all, place);
      }
      if (p.has("epoch") && is_of_satellites(message_type(each.text)))
        throw ComponentError(each.text + " needs channels that count GPS time: 'week' instead of 'epoch'", place);
      names.push_back(each.text);
    }
    rules_.asked_for = names;
  }
  for (const auto& name : names) {
    const int type = message_type(name);
    if (is_of_satellites(type) && p.has("epoch")) continue;
    rules_.decoder.wanted.set(static_cast<std::size_t>(type));
    has_satellites_ = has_satellites_ || is_of_satellites(type);
  }
  if (rules_.decoder.wanted.none()) throw ComponentError("no message is read", "/messages");
}

void UbloxSource::declare_channels() {
  for (ValueKind& kind : value_kinds()) {
    if (!rules_.decoder.wanted[static_cast<std::size_t>(kind.type)]) continue;
    ChannelDeclaration channel(kind.channel, std::move(kind.fields));
    if (kind.kind == Kind::imu || kind.kind == Kind::imu_raw) channel.max_interval = nanoseconds_per_second;
    channels_[static_cast<std::size_t>(kind.kind)] = declaration_.emits(std::move(channel));
  }
  if (has_satellites_) satellites_.declare(rules_.decoder.signals, declaration_);
  next_ = declaration_.keeps<std::uint64_t>();
}

void UbloxSource::open(Reporter& reporter) {
  if (live_) return live_->open(reporter);
  recording_ = read_recording(path_, rules_, reporter);
}

SourceStatus UbloxSource::next(const MemoryView& bytes, SourceOutput& output) const {
  if (live_) return next_of_live(output);
  std::uint64_t& next = bytes[next_];
  if (next >= recording_.events.size()) return SourceStatus::end;
  const auto& event = recording_.events[static_cast<std::size_t>(next++)];
  switch (event.part) {
    case Recording::Part::values: write(recording_.items[event.index], output); break;
    case Recording::Part::observations: satellites_.write(recording_.epochs[event.index], output); break;
    case Recording::Part::ephemerides:
      satellites_.write(recording_.sets[event.index], recording_.messages, output);
      break;
    case Recording::Part::klobuchar:
      satellites_.write(recording_.klobuchar[event.index].second, event.t, output);
      break;
  }
  return SourceStatus::sample;
}

SourceStatus UbloxSource::next_of_live(SourceOutput& output) const {
  LiveSample sample;
  const SourceStatus status = live_->next(sample);
  if (status != SourceStatus::sample) return status;
  switch (sample.part) {
    case Recording::Part::values: write(sample.item, output); break;
    case Recording::Part::observations: satellites_.write(sample.item.epoch, output); break;
    case Recording::Part::ephemerides: satellites_.write(sample.set, sample.messages, output); break;
    case Recording::Part::klobuchar: satellites_.write(*sample.item.broadcast.klobuchar, sample.item.t, output); break;
  }
  return SourceStatus::sample;
}

void UbloxSource::write(const Item& item, SourceOutput& output) const {
  SampleWriter& out = output.on(channels_[static_cast<std::size_t>(item.kind)]);
  out.t = item.t;
  out.t0 = item.t0;
  std::copy(item.values.begin(), item.values.end(), out.fields);
}

}  // namespace binnacle::ublox
