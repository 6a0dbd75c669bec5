// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a source, a swinging height with noise, and the truth beside it.
#include <binnacle/plugin.hpp>

#include <cmath>
#include <cstring>
#include <numbers>

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
    const std::vector<FieldSpec> fields{{"height", "m", FieldKind::level, false, false, "upward"}};
    channels_ = {{"seen", fields, 0, {}, 0}, {"truth", fields, 0, {}, 0}};
  }

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override { return sizeof(Cursor); }

  void start(std::uint64_t seed, std::byte* memory) const override {
    const Cursor cursor{seed, 0};
    std::memcpy(memory, &cursor, sizeof cursor);
  }

  SourceStatus next(std::byte* memory, SampleSlot* slots, int& channel) const override {
    Cursor cursor;
    std::memcpy(&cursor, memory, sizeof cursor);
    const std::int64_t epoch = cursor.emitted / 2;
    if (epoch < 0 || epoch >= samples_) return SourceStatus::end;
    channel = static_cast<int>(cursor.emitted % 2 != 0);
    SampleSlot& slot = slots[channel];
    slot.t = epoch * interval_;
    slot.fields[0] = amplitude_ * std::sin(2 * std::numbers::pi * seconds(slot.t) / period_);
    if (channel == 0) slot.fields[0] += sigma_ * normal(cursor.seed, static_cast<std::uint64_t>(epoch));
    ++cursor.emitted;
    std::memcpy(memory, &cursor, sizeof cursor);
    return SourceStatus::sample;
  }

 private:
  struct Cursor {
    std::uint64_t seed;
    std::int64_t emitted;  // samples of both channels
  };

  std::vector<ChannelDeclaration> channels_;
  double amplitude_;  // m
  double period_;     // s
  double sigma_;      // m
  Time interval_;
  std::int64_t samples_;  // per channel
};

BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<Swing>(); }
