// SPDX-License-Identifier: Apache-2.0
// Which broadcast message of a satellite is used when.
#include "message_choice.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>

namespace binnacle::rinex {

namespace {

using BySatellite = std::map<gnss::SatelliteKey, std::vector<std::size_t>>;

bool is_better(const Message& a, const Message& b, Choice choice, Time t) {
  if (choice == Choice::nearest_toe) {
    const Time age_a = std::abs(t - a.toe), age_b = std::abs(t - b.toe);
    if (age_a != age_b) return age_a < age_b;
  }
  return a.uploaded > b.uploaded;
}

MessageSet set_at(const std::vector<Message>& messages, const BySatellite& by_satellite, const ChoiceRules& rules,
                  Time t) {
  MessageSet set{t, {}};
  for (const auto& [satellite, indices] : by_satellite) {
    const Message* best = nullptr;
    for (const std::size_t i : indices) {
      const Message& message = messages[i];
      if (std::abs(t - message.toe) > rules.max_age) continue;
      if (rules.choice == Choice::upload && message.uploaded > t) continue;
      if (!best || is_better(message, *best, rules.choice, t)) best = &message;
    }
    if (best && (best->is_healthy || rules.takes_unhealthy))
      set.messages.push_back(static_cast<std::size_t>(best - messages.data()));
  }
  return set;
}

/// Every time at which a choice may change.
std::vector<Time> turning_points(const std::vector<Message>& messages, const BySatellite& by_satellite,
                                 const ChoiceRules& rules, Time first, Time last) {
  std::vector<Time> times{first};
  const auto add = [&](Time t) {
    if (t > first && t <= last) times.push_back(t);
  };
  for (const auto& [satellite, indices] : by_satellite)
    for (const std::size_t i : indices) {
      const Message& message = messages[i];
      add(message.toe - rules.max_age);
      add(message.toe + rules.max_age + 1);
      if (rules.choice == Choice::upload) {
        add(message.uploaded);
      } else {
        for (const std::size_t j : indices) {
          const Time middle = message.toe + (messages[j].toe - message.toe) / 2;
          add(middle);
          add(middle + 1);
        }
      }
    }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

}  // namespace

std::vector<MessageSet> choose_messages(const std::vector<Message>& messages, const ChoiceRules& rules, Time first,
                                        Time last) {
  BySatellite by_satellite;
  for (std::size_t i = 0; i < messages.size(); ++i) by_satellite[messages[i].ephemeris.satellite].push_back(i);
  std::vector<MessageSet> sets;
  for (const Time t : turning_points(messages, by_satellite, rules, first, last)) {
    MessageSet set = set_at(messages, by_satellite, rules, t);
    if (sets.empty() || sets.back().messages != set.messages) sets.push_back(std::move(set));
  }
  return sets;
}

}  // namespace binnacle::rinex
