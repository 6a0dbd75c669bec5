// SPDX-License-Identifier: Apache-2.0
// Epochs of a RINEX observation file.
#pragma once

#include <string>
#include <vector>

#include "gnss/observation_channels.hpp"
#include "text/faults.hpp"

namespace binnacle::rinex {

using text_file::Faults;

using gnss::Observation;
using gnss::Signals;
using Epoch = gnss::ObservationEpoch;

/// Epochs in order of time. Times count from the begin of GPS week `origin_week`.
std::vector<Epoch> read_observations(const std::string& path, int origin_week, const Signals& signals, Faults& faults);

}  // namespace binnacle::rinex
