// SPDX-License-Identifier: Apache-2.0
// Epochs of a receiver that is connected.
#pragma once

#include <vector>

#include "decoder.hpp"
#include "line_input/lines.hpp"

namespace binnacle::nmea {

class LiveEpochs {
 public:
  LiveEpochs(const Parameters& parameters, const UtcClock& clock, const Decoder::Options& options);

  void open(Reporter& reporter);
  int wait_handle() const { return lines_.wait_handle(); }
  SourceFigures figures() const { return lines_.figures(); }

  /// Epochs that came are appended. wait: none so far; end: there will be no more.
  SourceStatus next(std::vector<Epoch>& epochs);

 private:
  void take(std::string_view line, std::vector<Epoch>& epochs);

  UtcClock clock_;
  Decoder::Options options_;
  Decoder decoder_;
  line_input::Lines lines_;
  bool is_over_ = false;
};

}  // namespace binnacle::nmea
