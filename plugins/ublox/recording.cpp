// SPDX-License-Identifier: Apache-2.0
#include "recording.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>

#include "binnacle/parameters.hpp"
#include "reports.hpp"
#include "text/in_order.hpp"
#include "text/text_file.hpp"

namespace binnacle::ublox {

namespace {

constexpr std::size_t block = 1 << 16;

std::string at_byte(std::uint64_t at) { return "byte " + std::to_string(at); }

/// Counted by what is wrong, and reported when all is read.
class Faults final : public Complaints {
 public:
  Faults(std::string path, bool stops) : path_(std::move(path)), stops_(stops) {}

  void damage(const char* code, const std::string& why, std::uint64_t at) override {
    if (stops_) throw ComponentError::in_data(why + ", at " + at_byte(at), path_, 0, code);
    note(code, why, at);
  }
  void note(const char* code, const std::string& why, std::uint64_t at) override {
    Kind& kind = kinds_[{code, why}];
    if (kind.count++ == 0) kind.first_at = at;
  }
  void report(Reporter& reporter) const {
    for (const auto& [key, kind] : kinds_)
      reporter.warn(key.first, path_, 0,
                    std::to_string(kind.count) + " × " + key.second + ", left out" +
                        (kind.count == 1 ? ", at " : ", the first at ") + at_byte(kind.first_at));
  }

 private:
  struct Kind {
    std::uint64_t count = 0, first_at = 0;
  };
  std::string path_;
  bool stops_;
  std::map<std::pair<std::string, std::string>, Kind> kinds_;
};

class Reader {
 public:
  Reader(const std::string& path, const ReadingRules& rules, Reporter& reporter)
      : path_(path), rules_(rules), reporter_(reporter), faults_(path, rules.stops_on_error), decoder_(rules.decoder) {}

  Recording read() {
    if (const auto start = first_instant()) decoder_.start_near(*start);
    each_frame([&](const Frame& frame) {
      ++read_[frame.type()];
      decoder_.take(frame, items_, faults_);
      return true;
    });
    decoder_.finish(items_);
    sort_out();
    arrange();
    report();
    return std::move(recording_);
  }

 private:
  /// Until `take` returns false. The framer's counts are kept.
  template <class Take>
  void each_frame(Take&& take) {
    Framer framer;
    bool goes_on = true;
    try {
      text_file::ByteStream stream(path_);
      std::string bytes(block, '\0');
      Frame frame;
      while (goes_on) {
        const std::size_t count = stream.read(bytes.data(), bytes.size());
        if (count == 0) framer.finish();
        framer.append(std::string_view(bytes).substr(0, count));
        while (goes_on && framer.next(frame)) goes_on = take(frame);
        if (count == 0) break;
      }
    } catch (const text_file::FileFault& fault) {
      if (fault.code == "B060" || rules_.stops_on_error)
        throw ComponentError::in_data(fault.what(), path_, 0, fault.code);
      damage_ = fault.what();
      framer.finish();
      Frame frame;
      while (goes_on && framer.next(frame)) goes_on = take(frame);
    }
    counts_ = framer.counts();
  }

  std::optional<Time> first_instant() {
    std::optional<Time> first;
    each_frame([&](const Frame& frame) {
      first = decoder_.instant_of(frame);
      return !first;
    });
    return first;
  }

  /// By kind, each in order of time, on the clock of channels.
  void sort_out() {
    std::array<std::vector<Item>, kind_count> by_kind;
    for (Item& item : items_) {
      put_on_clock(item, decoder_, rules_.decoder.clock);
      by_kind[static_cast<std::size_t>(item.kind)].push_back(std::move(item));
    }
    for (std::size_t k = 0; k < by_kind.size(); ++k) {
      const auto kind = static_cast<Kind>(k);
      if (kind == Kind::subframe) {
        take_subframes(by_kind[k]);
        continue;
      }
      auto ordered = text_file::in_order(
          std::move(by_kind[k]), [](const Item& item) { return item.t; },
          [&](const Item& item, const Item&) {
            faults_.damage("B063", "samples of '" + channel_name(kind) + "' that are not younger than the one before",
                           item.at);
          });
      for (Item& item : ordered)
        if (kind == Kind::obs)
          recording_.epochs.push_back(std::move(item.epoch));
        else
          recording_.items.push_back(std::move(item));
    }
  }

  void take_subframes(std::vector<Item>& items) {
    for (Item& item : items) {
      if (item.broadcast.message && rules_.decoder.signals.takes(item.broadcast.message->ephemeris.satellite))
        recording_.messages.push_back(*item.broadcast.message);
      if (item.broadcast.klobuchar) recording_.klobuchar.emplace_back(item.t, *item.broadcast.klobuchar);
    }
  }

  void arrange() {
    using Part = Recording::Part;
    auto& [items, epochs, messages, sets, klobuchar, events] = recording_;
    for (std::size_t i = 0; i < items.size(); ++i) events.push_back({items[i].t, Part::values, i});
    for (std::size_t i = 0; i < epochs.size(); ++i) events.push_back({epochs[i].t, Part::observations, i});
    Time first = std::numeric_limits<Time>::max(), last = std::numeric_limits<Time>::min();
    for (const auto& event : events) first = std::min(first, event.t), last = std::max(last, event.t);
    for (const auto& message : messages)
      first = std::min(first, message.uploaded), last = std::max(last, message.uploaded);
    const bool has_all_from_begin = rules_.messages.choice == gnss::Choice::nearest_toe;
    if (!messages.empty()) sets = gnss::choose_messages(messages, rules_.messages, first, last);
    for (std::size_t i = 0; i < sets.size(); ++i)
      if (i > 0 || !sets[i].messages.empty()) events.push_back({sets[i].t, Part::ephemerides, i});
    for (std::size_t i = 0; i < klobuchar.size(); ++i)
      events.push_back({has_all_from_begin && i == 0 ? first : klobuchar[i].first, Part::klobuchar, i});
    std::stable_sort(events.begin(), events.end(),
                     [](const auto& a, const auto& b) { return a.t != b.t ? a.t < b.t : a.part < b.part; });
  }

  void report_orphans() {
    gnss::Orphans orphans;
    const gnss::MessageSet* set = nullptr;
    for (const auto& event : recording_.events) {
      if (event.part == Recording::Part::ephemerides) set = &recording_.sets[event.index];
      if (event.part == Recording::Part::observations)
        orphans.add(recording_.epochs[event.index], set, recording_.messages);
    }
    if (const std::string text = orphans.text(); !text.empty()) reporter_.warn("B065", path_, 0, text);
  }

  void report() {
    if (!damage_.empty()) reporter_.warn("B061", path_, 0, damage_ + "; the data before it are kept");
    for_each_count(counts_, [&](const char* code, const std::string& text, std::uint64_t at) {
      const bool is_text = std::string_view(code) == "B065";
      if (rules_.stops_on_error && !is_text) throw ComponentError::in_data(text + " at " + at_byte(at), path_, 0, code);
      reporter_.warn(code, path_, 0, text + ", the first at " + at_byte(at));
    });
    if (const std::string text = text_of(decoder_.passed_over()); !text.empty()) reporter_.warn("B065", path_, 0, text);
    faults_.report(reporter_);
    for (const std::string& name : rules_.asked_for)
      if (read_.count(message_type(name)) == 0) reporter_.warn("B066", path_, 0, "holds no " + name);
    report_sensors("ESF-MEAS", decoder_.sensor_clock());
    report_sensors("ESF-RAW", decoder_.raw_sensor_clock());
    if (const auto jumps = gnss::find_clock_jumps(recording_.epochs); !jumps.text.empty())
      reporter_.warn("B065", path_, 0, jumps.text);
    if (!recording_.epochs.empty() && rules_.decoder.wanted[rxm_sfrbx]) report_orphans();
    if (recording_.events.empty())
      throw ComponentError::in_data("no message gives a sample" +
                                        std::string(counts_.frame_bytes == 0 ? "; is it UBX?" : ""),
                                    path_, 0, "B066");
  }

  void report_sensors(const char* name, const SensorClock& clock) {
    if (clock.offset() == no_time) return;
    char text[240];
    std::snprintf(text, sizeof text,
                  "times of %s are converted to GPS time by their order among the epochs; later epochs differ by %+.1f "
                  "to %+.1f ms; they are early by the receiver's latency ('sensor_shift')%s",
                  name, static_cast<double>(clock.least_apart()) * 1e-6, static_cast<double>(clock.most_apart()) * 1e-6,
                  clock.jumps() > 0 ? "; the sensor's clock was set in between" : "");
    reporter_.warn("B065", path_, 0, text);
  }

  const std::string& path_;
  const ReadingRules& rules_;
  Reporter& reporter_;
  Faults faults_;
  Decoder decoder_;
  Framer::Counts counts_;
  std::string damage_;
  std::map<int, std::uint64_t> read_;
  std::vector<Item> items_;
  Recording recording_;
};

}  // namespace

Recording read_recording(const std::string& path, const ReadingRules& rules, Reporter& reporter) {
  return Reader(path, rules, reporter).read();
}

/// Ephemerides carry times too; their channels count GPS time.
void put_on_clock(Item& item, const Decoder& decoder, const civil_time::UtcClock& clock) {
  const auto leap = decoder.leap_seconds() ? std::optional(decoder.leap()) : std::nullopt;
  const auto channel = [&](Time gps) { return gps == no_time ? no_time : clock.time_of_gps(gps, leap); };
  item.t = channel(item.t);
  item.t0 = channel(item.t0);
  item.epoch.t = channel(item.epoch.t);
  if (!item.broadcast.message) return;
  gnss::BroadcastMessage& m = *item.broadcast.message;
  const Time shift = channel(m.toe) - m.toe;
  m.toe += shift;
  m.uploaded += shift;
  m.ephemeris.toe += seconds(shift);
  m.ephemeris.toc += seconds(shift);
}

}  // namespace binnacle::ublox
