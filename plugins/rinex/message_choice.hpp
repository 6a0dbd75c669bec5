// SPDX-License-Identifier: Apache-2.0
// Which broadcast message of a satellite is used when.
#pragma once

#include <vector>

#include "navigation_file.hpp"

namespace binnacle::rinex {

/// nearest_toe: the one whose reference time is nearest, uploaded or not: what post-processing does.
/// upload: the latest that had been transmitted: what a receiver has.
enum class Choice { nearest_toe, upload };

struct ChoiceRules {
  Choice choice = Choice::upload;
  Time max_age = 0;              // |t − toe| at most
  bool takes_unhealthy = false;  // else a satellite whose message says so is not used
};

/// From `t` on these messages (indices, at most one a satellite) are used.
struct MessageSet {
  Time t = no_time;
  std::vector<std::size_t> messages;
};

/// The sets from `first` to `last`; each differs from the one before.
std::vector<MessageSet> choose_messages(const std::vector<Message>& messages, const ChoiceRules& rules, Time first,
                                        Time last);

}  // namespace binnacle::rinex
