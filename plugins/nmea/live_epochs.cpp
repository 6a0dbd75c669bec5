// SPDX-License-Identifier: Apache-2.0
#include "live_epochs.hpp"

#include "reports.hpp"

namespace binnacle::nmea {

LiveEpochs::LiveEpochs(const Parameters& parameters, const UtcClock& clock, const Decoder::Options& options)
    : clock_(clock), options_(options), decoder_(clock, options), lines_(parameters) {}

void LiveEpochs::open(Reporter& reporter) {
  decoder_ = Decoder(clock_, options_);
  is_over_ = false;
  lines_.open(reporter);
}

SourceStatus LiveEpochs::next(std::vector<Epoch>& epochs) {
  constexpr int most_lines = 1000;  // without an epoch, before the others are asked again
  for (int lines = 0; lines < most_lines && !is_over_; ++lines) {
    std::string_view line;
    switch (lines_.next(line)) {
      case line_input::Lines::Got::line: take(line, epochs); break;
      case line_input::Lines::Got::nothing: return SourceStatus::wait;
      case line_input::Lines::Got::anew: break;  // the receiver's day and order of sentences are as before
      case line_input::Lines::Got::end: decoder_.finish(epochs); is_over_ = true;
    }
    if (epochs.empty()) continue;
    if (lines_.stamps_arrival())
      for (Epoch& epoch : epochs) epoch.t = line_input::monotonic_now();
    return SourceStatus::sample;
  }
  return is_over_ ? SourceStatus::end : SourceStatus::wait;
}

void LiveEpochs::take(std::string_view line, std::vector<Epoch>& epochs) {
  const Decoder::Counts before = decoder_.counts();
  const std::size_t kinds = decoder_.passed_over().size();
  const auto outcome = decoder_.take(line, epochs);
  if (decoder_.passed_over().size() > kinds) lines_.note(text_of(decoder_.passed_over()) + " so far", "B065");
  if (outcome != Decoder::Outcome::used && outcome != Decoder::Outcome::ignored)
    lines_.complain("it is a sentence " + std::string(words_of(outcome)), code_of(outcome));
  for_each_note([&](const char* code, std::int64_t Decoder::Counts::*count, const std::string& what) {
    if (decoder_.counts().*count > before.*count) lines_.note(what, code);
  });
}

}  // namespace binnacle::nmea
