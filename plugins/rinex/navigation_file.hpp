// SPDX-License-Identifier: Apache-2.0
// Broadcast messages of a RINEX navigation file.
#pragma once

#include <optional>
#include <vector>

#include "gnss/atmosphere.hpp"
#include "gnss/message_choice.hpp"
#include "text/faults.hpp"

namespace binnacle::rinex {

using text_file::Faults;
using text_file::OnInvalid;

using Message = gnss::BroadcastMessage;

struct Navigation {
  std::vector<Message> messages;  // in the order of the file
  std::optional<gnss::Klobuchar> klobuchar;
};

/// Messages of GPS (LNAV) and Galileo (I/NAV); those of other systems are passed over.
/// Times count from the begin of GPS week `origin_week`.
Navigation read_navigation(const std::string& path, int origin_week, Faults& faults);

}  // namespace binnacle::rinex
