// SPDX-License-Identifier: Apache-2.0
// What sources of GNSS observations share: which signals are taken, their three channels, and what is said of satellites
// without a message.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "binnacle/source.hpp"
#include "gnss/atmosphere.hpp"
#include "gnss/message_choice.hpp"
#include "gnss/observation_epoch.hpp"

namespace binnacle::gnss {

/// Which observations are taken: those whose RINEX code ends so ("1C": C1C, D1C, S1C, L1C; in RINEX 2 C1, D1, S1, L1).
/// An empty code: none of this constellation.
struct Signals {
  std::string gps = "1C";
  std::string galileo = "1C";

  static ParameterSpec parameter();
  /// Throws ComponentError where a code is none of the first frequency.
  static Signals of(const Parameters& parameters);
  const std::string& of(Constellation constellation) const {
    return constellation == Constellation::galileo ? galileo : gps;
  }
  bool takes(SatelliteKey key) const { return !of(constellation_of(key)).empty(); }
};

/// `obs`, `ephemeris` and `iono`.
class ObservationChannels {
 public:
  void declare(const Signals& signals, SourceDeclaration& declaration);

  void write(const ObservationEpoch& epoch, SourceOutput& output) const;
  void write(const MessageSet& set, const std::vector<BroadcastMessage>& messages, SourceOutput& output) const;
  void write(const Klobuchar& klobuchar, Time t, SourceOutput& output) const;

 private:
  OutputChannel obs_, ephemeris_, iono_;
  OutputField event_, clock_offset_, clock_jump_;
  OutputRowField satellite_, pseudorange_, range_rate_, cn0_;
  OutputFields<4> alpha_, beta_;
};

/// Counts satellites that are observed while no message of theirs may be used.
class Orphans {
 public:
  void add(const ObservationEpoch& epoch, const MessageSet* set, const std::vector<BroadcastMessage>& messages);
  /// Empty: there is none.
  std::string text() const;
  int first_line() const { return first_line_; }

 private:
  std::map<SatelliteKey, std::size_t> missing_;
  int first_line_ = 0;
};

}  // namespace binnacle::gnss
