// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a source, a swinging height with noise, and the truth beside it.
#include <binnacle/plugin.hpp>

#include <cmath>
#include <numbers>
#include <utility>

using namespace binnacle;

namespace {

/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): a random number per counter, so the counter is all that is kept.
std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

/// In (0, 1].
double uniform(std::uint64_t seed, std::uint64_t counter) {
  return static_cast<double>((mixed(mixed(seed) + counter) >> 11) + 1) * 0x1p-53;
}

/// N(0, 1), by Box and Muller.
double normal(std::uint64_t seed, std::uint64_t counter) {
  const double angle = 2 * std::numbers::pi * uniform(seed, 2 * counter + 1);
  return std::sqrt(-2 * std::log(uniform(seed, 2 * counter))) * std::cos(angle);
}

}  // namespace

/// height(t) = amplitude · sin(2π t / period) on NAME.truth; the same plus white noise on NAME.seen.
class Swing final : public Source {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "A height that swings, seen with white noise, and the truth beside it.";
    spec.parameters = {parameter::number("amplitude", "m").defaults("\"1 m\"").about("half of the swing"),
                       parameter::number("period", "s").above(0).defaults("\"10 s\"").about("of the swing"),
                       parameter::number("sigma", "m").at_least(0).defaults("\"0.1 m\"").about("of the noise"),
                       parameter::time("interval").above(0).defaults("\"0.1 s\"").about("from sample to sample"),
                       parameter::time("duration").at_least(0).defaults("\"60 s\"").about("of the whole")};
    spec.example = R"json({"amplitude": "2 m", "period": "20 s", "duration": "30 s"})json";
    return spec;
  }

  explicit Swing(const Binding& b)
      : amplitude_(b.parameters().number("amplitude")),
        period_(b.parameters().number("period")),
        sigma_(b.parameters().number("sigma")),
        interval_(b.parameters().time("interval")),
        samples_(b.parameters().time("duration") / interval_ + 1) {
    ChannelDeclaration seen("seen"), truth("truth");
    seen_height_ = seen.carries(field::level("height", "m").about("upward"));
    true_height_ = truth.carries(field::level("height", "m").about("upward"));
    seen_ = declaration_.emits(std::move(seen));
    truth_ = declaration_.emits(std::move(truth));
    cursor_ = declaration_.keeps<Cursor>();
  }

  SourceStatus next(const MemoryView& memory, SourceOutput& output) const override {
    Cursor& cursor = memory[cursor_];
    const std::int64_t epoch = cursor.emitted / 2;
    if (epoch < 0 || epoch >= samples_) return SourceStatus::end;
    const bool is_truth = cursor.emitted++ % 2 != 0;
    const Time t = epoch * interval_;
    const double height = amplitude_ * std::sin(2 * std::numbers::pi * seconds(t) / period_);
    SampleWriter& out = output.on(is_truth ? truth_ : seen_);
    out.t = t;
    if (is_truth)
      out[true_height_] = height;
    else
      out[seen_height_] = height + sigma_ * normal(cursor.seed, static_cast<std::uint64_t>(epoch));
    return SourceStatus::sample;
  }

 private:
  struct Cursor {
    std::uint64_t seed = 0;
    std::int64_t emitted = 0;  // samples of both channels
  };
  void initialise(std::uint64_t seed, const MemoryView& memory) const override { memory[cursor_].seed = seed; }

  OutputChannel seen_, truth_;
  OutputField seen_height_, true_height_;
  Memory<Cursor> cursor_;
  double amplitude_;  // m
  double period_;     // s
  double sigma_;      // m
  Time interval_;
  std::int64_t samples_;  // per channel
};

BINNACLE_TYPES("@NAME@");
BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<Swing>(); }
