// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a transform, the mean of every few samples.
#include <binnacle/plugin.hpp>

#include <cmath>
#include <cstring>

using namespace binnacle;

/// Emits the mean of `window` heights with the time of the last one, and begins anew. White noise of σ stays white,
/// with σ/√window, where a moving mean would correlate it. Heights that are not finite are left out.
class Mean final : public Transform {
 public:
  static ComponentSpec spec() {
    ComponentSpec spec;
    spec.type = "@NAME@";
    spec.summary = "The mean of every few samples of a height.";
    spec.parameters = {parameter::integer("window").at_least(1).defaults("5").about("samples in a mean")};
    spec.inputs = {{"input", {{"height", "m", FieldKind::level, false, false, "upward"}}, false, "what is averaged"}};
    spec.example = R"json({"input": "heights", "window": 10})json";
    return spec;
  }

  explicit Mean(const Binding& b) : window_(static_cast<std::uint64_t>(b.parameters().integer("window"))) {
    channels_ = {{"", {{"height", "m", FieldKind::level, false, false, "upward, the mean"}}, 0, {}, 0}};
  }

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  std::size_t memory_bytes() const noexcept override { return sizeof(Sum); }

  void on(int, const SampleView& sample, std::byte* memory, Emitter& emitter) const override {
    if (!std::isfinite(sample.fields[0])) return;
    Sum sum;
    std::memcpy(&sum, memory, sizeof sum);
    sum.heights += sample.fields[0];
    if (++sum.count >= window_) {
      SampleSlot& slot = emitter.slot(0);
      slot.t = sample.t;
      slot.fields[0] = sum.heights / static_cast<double>(sum.count);
      emitter.emit(0);
      sum = {};
    }
    std::memcpy(memory, &sum, sizeof sum);
  }

 private:
  /// Begins as zeros.
  struct Sum {
    std::uint64_t count;
    double heights;  // m
  };

  std::vector<ChannelDeclaration> channels_;
  std::uint64_t window_;
};

BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<Mean>(); }
