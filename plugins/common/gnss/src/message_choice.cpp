// SPDX-License-Identifier: Apache-2.0
// Which broadcast message of a satellite is used when.
#include "gnss/message_choice.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>

namespace binnacle::gnss {

namespace {

using BySatellite = std::map<SatelliteKey, std::vector<std::size_t>>;

bool is_better(const BroadcastMessage& a, const BroadcastMessage& b, Choice choice, Time t) {
  if (a.is_substitute != b.is_substitute) return b.is_substitute;
  if (choice == Choice::nearest_toe) {
    const Time age_a = std::abs(t - a.toe), age_b = std::abs(t - b.toe);
    if (age_a != age_b) return age_a < age_b;
  }
  return a.uploaded > b.uploaded;
}

BySatellite sorted(const std::vector<BroadcastMessage>& messages) {
  BySatellite by_satellite;
  for (std::size_t i = 0; i < messages.size(); ++i) by_satellite[messages[i].ephemeris.satellite].push_back(i);
  return by_satellite;
}

MessageSet set_at(const std::vector<BroadcastMessage>& messages, const BySatellite& by_satellite,
                  const ChoiceRules& rules, Time t) {
  MessageSet set{t, {}};
  for (const auto& [satellite, indices] : by_satellite) {
    const BroadcastMessage* best = nullptr;
    for (const std::size_t i : indices) {
      const BroadcastMessage& message = messages[i];
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
std::vector<Time> turning_points(const std::vector<BroadcastMessage>& messages, const BySatellite& by_satellite,
                                 const ChoiceRules& rules, Time first, Time last) {
  std::vector<Time> times{first};
  const auto add = [&](Time t) {
    if (t > first && t <= last) times.push_back(t);
  };
  for (const auto& [satellite, indices] : by_satellite)
    for (const std::size_t i : indices) {
      const BroadcastMessage& message = messages[i];
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

std::vector<ParameterSpec> ChoiceRules::parameters() {
  return {parameter::choice("choose", {"upload", "nearest_toe"})
              .defaults("\"upload\"")
              .about("selection of the message: the latest transmitted, as in a receiver, or the one with the nearest "
                     "reference time, which may not have been transmitted yet"),
          parameter::time("max_age").above(0).at_most(604800).defaults("\"2 h\"").about(
              "longest time between an epoch and a message's reference time"),
          parameter::boolean("unhealthy")
              .defaults("false")
              .about("true: use satellites whose message marks them as unhealthy")};
}

ChoiceRules ChoiceRules::of(const Parameters& parameters) {
  return {parameters.text("choose") == "upload" ? Choice::upload : Choice::nearest_toe, parameters.time("max_age"),
          parameters.boolean("unhealthy")};
}

std::vector<MessageSet> choose_messages(const std::vector<BroadcastMessage>& messages, const ChoiceRules& rules,
                                        Time first, Time last) {
  const BySatellite by_satellite = sorted(messages);
  std::vector<MessageSet> sets;
  for (const Time t : turning_points(messages, by_satellite, rules, first, last)) {
    MessageSet set = set_at(messages, by_satellite, rules, t);
    if (sets.empty() || sets.back().messages != set.messages) sets.push_back(std::move(set));
  }
  return sets;
}

MessageSet choose_messages_at(const std::vector<BroadcastMessage>& messages, const ChoiceRules& rules, Time t) {
  return set_at(messages, sorted(messages), rules, t);
}

}  // namespace binnacle::gnss
