// SPDX-License-Identifier: Apache-2.0
// Broadcast messages of a RINEX navigation file.
#pragma once

#include <optional>
#include <vector>

#include "faults.hpp"
#include "gnss/atmosphere.hpp"
#include "gnss/message_choice.hpp"

namespace binnacle::rinex {

using Message = gnss::BroadcastMessage;

struct Navigation {
  std::vector<Message> messages;  // in the order of the file
  std::optional<gnss::Klobuchar> klobuchar;
};

/// Messages of GPS (LNAV) and Galileo (I/NAV); those of other systems are passed over.
/// Times count from the begin of GPS week `origin_week`.
Navigation read_navigation(const std::string& path, int origin_week, Faults& faults);

}  // namespace binnacle::rinex
