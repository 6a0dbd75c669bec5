// SPDX-License-Identifier: Apache-2.0
// The plugin @NAME@: a transform, the mean of every few samples.
#include <binnacle/plugin.hpp>

#include <cmath>
#include <utility>

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
    spec.inputs = {input("input", {field::level("height", "m").about("upward")}).about("what is averaged")};
    spec.example = R"json({"input": "heights", "window": 10})json";
    return spec;
  }

  explicit Mean(const Binding& b)
      : height_(b.field(b.input("input"), "height")),
        window_(static_cast<std::uint64_t>(b.parameters().integer("window"))) {
    ChannelDeclaration means;
    mean_ = means.carries(field::level("height", "m").about("upward, the mean"));
    means_ = declaration_.emits(std::move(means));
    sum_ = declaration_.keeps<Sum>();
  }

  void on(const TransformInput& in, Emitter& emitter) const override {
    const double height = in.sample[height_];
    if (!std::isfinite(height)) return;
    Sum& sum = in.memory[sum_];
    sum.heights += height;
    if (++sum.count < window_) return;
    SampleWriter& out = emitter.on(means_);
    out.t = in.sample.t;
    out[mean_] = sum.heights / static_cast<double>(sum.count);
    emitter.emit(means_);
    sum = {};
  }

 private:
  struct Sum {
    std::uint64_t count = 0;
    double heights = 0;  // m
  };

  Field height_;
  OutputChannel means_;
  OutputField mean_;
  Memory<Sum> sum_;
  std::uint64_t window_;
};

BINNACLE_TYPES("@NAME@");
BINNACLE_PLUGIN("@NAME@", "0.1.0", registry) { registry.add<Mean>(); }
