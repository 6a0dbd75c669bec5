// SPDX-License-Identifier: Apache-2.0
// Broadcast messages, and which one of a satellite is used when.
#pragma once

#include <vector>

#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"
#include "gnss/orbit.hpp"

namespace binnacle::gnss {

struct BroadcastMessage {
  Ephemeris ephemeris;
  Time toe = no_time;
  Time uploaded = no_time;  // from when on a receiver has it
  bool is_healthy = false;
  int line = 0;  // of a text file
};

/// nearest_toe: the one whose reference time is nearest, uploaded or not: what post-processing does.
/// upload: the latest that had been transmitted: what a receiver has.
enum class Choice { nearest_toe, upload };

struct ChoiceRules {
  Choice choice = Choice::upload;
  Time max_age = 0;              // |t − toe| at most
  bool takes_unhealthy = false;  // else a satellite whose message says so is not used

  /// `choose`, `max_age`, `unhealthy`.
  static std::vector<ParameterSpec> parameters();
  static ChoiceRules of(const Parameters& parameters);
};

/// From `t` on these messages (indices, at most one a satellite) are used.
struct MessageSet {
  Time t = no_time;
  std::vector<std::size_t> messages;
};

/// The sets from `first` to `last`; each differs from the one before.
std::vector<MessageSet> choose_messages(const std::vector<BroadcastMessage>& messages, const ChoiceRules& rules,
                                        Time first, Time last);
/// The set at one time.
MessageSet choose_messages_at(const std::vector<BroadcastMessage>& messages, const ChoiceRules& rules, Time t);

}  // namespace binnacle::gnss
