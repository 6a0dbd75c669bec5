// SPDX-License-Identifier: Apache-2.0
#include "live_messages.hpp"

#include <algorithm>
#include <utility>

#include "reports.hpp"

namespace binnacle::ublox {

namespace {

constexpr std::size_t most_messages_of_a_satellite = 3;

bool is_same_ephemeris(const gnss::Ephemeris& a, const gnss::Ephemeris& b) {
  return a.satellite == b.satellite && a.toe == b.toe && a.issue == b.issue && a.af0 == b.af0;
}

}  // namespace

class LiveMessages::Notes final : public Complaints {
 public:
  explicit Notes(LiveMessages& live) : live_(live) {}
  void damage(const char* code, const std::string& why, std::uint64_t) override {
    ++live_.unusable_;
    if (live_.bytes_.stops()) throw ComponentError::in_data(why, live_.bytes_.from(), 0, code);
    live_.bytes_.note(why + ", left out", code);
  }
  void note(const char* code, const std::string& why, std::uint64_t) override {
    live_.bytes_.note(why + ", left out", code);
  }

 private:
  LiveMessages& live_;
};

LiveMessages::LiveMessages(const Parameters& parameters, const ReadingRules& rules)
    : rules_(rules), bytes_(parameters, false), decoder_(rules.decoder) {}

void LiveMessages::open(Reporter& reporter) {
  framer_ = Framer();
  decoder_ = Decoder(rules_.decoder);
  told_ = {};
  told_passed_over_.clear();
  waiting_.clear();
  newest_.clear();
  messages_.clear();
  last_set_.clear();
  last_epoch_ = {};
  unusable_ = 0;
  is_over_ = false;
  bytes_.open(reporter);
}

SourceFigures LiveMessages::figures() const {
  SourceFigures figures = bytes_.figures();
  figures.waiting = static_cast<std::int64_t>(waiting_.size());
  figures.unusable = unusable_;
  return figures;
}

SourceStatus LiveMessages::next(LiveSample& sample) {
  constexpr int most_reads = 100;  // without a sample, before the others are asked again
  Notes notes(*this);
  for (int reads = 0; waiting_.empty() && !is_over_ && reads < most_reads; ++reads) {
    const auto got = bytes_.read(framer_.buffer());
    if (got == line_input::Bytes::Got::nothing) return SourceStatus::wait;
    if (got == line_input::Bytes::Got::lost || got == line_input::Bytes::Got::found) {
      framer_.begin_anew();
      bytes_.warn(got == line_input::Bytes::Got::lost
                      ? "there is no connection, or it was lost; the program tries again every second"
                      : "the connection is restored",
                  "B067");
    }
    std::vector<Item> items;
    if (got == line_input::Bytes::Got::end) {
      framer_.finish();
      is_over_ = true;
    }
    Frame frame;
    while (framer_.next(frame)) decoder_.take(frame, items, notes);
    if (is_over_) decoder_.finish(items);
    report_counts();
    for (Item& item : items) take(item);
  }
  if (waiting_.empty()) return is_over_ ? SourceStatus::end : SourceStatus::wait;
  sample = std::move(waiting_.front());
  waiting_.pop_front();
  return SourceStatus::sample;
}

void LiveMessages::take(Item& item) {
  put_on_clock(item, decoder_, rules_.decoder.clock);
  if (item.kind == Kind::subframe) return take_broadcast(item);
  Time& newest = newest_.try_emplace(item.kind, no_time).first->second;
  if (newest != no_time && item.t <= newest) {
    Notes(*this).damage("B063", "samples of '" + channel_name(item.kind) + "' that are not younger than the one before",
                        item.at);
    return;
  }
  newest = item.t;
  const bool is_observation = item.kind == Kind::obs;
  if (is_observation) {
    if (last_epoch_.t != no_time) item.epoch.clock_jump = gnss::clock_jump(last_epoch_, item.epoch);
    last_epoch_ = item.epoch;
    renew_set(item.t);
  }
  if (bytes_.stamps_arrival()) {
    item.t = item.epoch.t = line_input::monotonic_now();
    item.t0 = no_time;
  }
  waiting_.push_back(
      {is_observation ? Recording::Part::observations : Recording::Part::values, std::move(item), {}, {}});
}

void LiveMessages::take_broadcast(const Item& item) {
  if (item.broadcast.klobuchar) waiting_.push_back({Recording::Part::klobuchar, item, {}, {}});
  if (!item.broadcast.message) return;
  const auto satellite = item.broadcast.message->ephemeris.satellite;
  if (!rules_.decoder.signals.takes(satellite)) return;
  const auto is_of_it = [&](const gnss::BroadcastMessage& m) { return m.ephemeris.satellite == satellite; };
  if (static_cast<std::size_t>(std::count_if(messages_.begin(), messages_.end(), is_of_it)) >=
      most_messages_of_a_satellite)
    messages_.erase(std::find_if(messages_.begin(), messages_.end(), is_of_it));
  messages_.push_back(*item.broadcast.message);
}

void LiveMessages::renew_set(Time t) {
  gnss::MessageSet set = gnss::choose_messages_at(messages_, rules_.messages, t);
  std::vector<gnss::Ephemeris> chosen;
  for (const std::size_t i : set.messages) chosen.push_back(messages_[i].ephemeris);
  if (std::equal(chosen.begin(), chosen.end(), last_set_.begin(), last_set_.end(), is_same_ephemeris)) return;
  last_set_ = std::move(chosen);
  LiveSample sample;
  sample.part = Recording::Part::ephemerides;
  sample.set = std::move(set);
  sample.messages = messages_;
  waiting_.push_back(std::move(sample));
}

/// Each kind when it is new, and then each time that it has become ten times as much.
void LiveMessages::report_counts() {
  const Framer::Counts& now = framer_.counts();
  const bool has_grown = now.garbage.count >= std::max<std::uint64_t>(1, 10 * told_.garbage.count) ||
                         now.bad_checksums.runs >= std::max<std::uint64_t>(1, 10 * told_.bad_checksums.runs) ||
                         now.cut.count >= std::max<std::uint64_t>(1, 10 * told_.cut.count) ||
                         now.text.count >= std::max<std::uint64_t>(1, 10 * told_.text.count);
  if (has_grown) {
    told_ = now;
    for_each_count(now, [&](const char* code, const std::string& text, std::uint64_t at) {
      const bool is_damage = std::string_view(code) != "B065";
      unusable_ += is_damage;
      if (is_damage && bytes_.stops())
        throw ComponentError::in_data(text + ", at byte " + std::to_string(at), bytes_.from(), 0, code);
      bytes_.warn(text + " so far", code);
    });
  }
  if (decoder_.passed_over().size() == told_passed_over_.size()) return;
  told_passed_over_ = decoder_.passed_over();
  bytes_.warn(text_of(told_passed_over_) + " so far", "B065");
}

}  // namespace binnacle::ublox
