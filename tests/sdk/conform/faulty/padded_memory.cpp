// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: what its components keep has padding, whose bytes are whatever stood there, in no two objects the same.
// fails: nothing
#include <atomic>
#include <cstring>

#include "faulty.hpp"

namespace {

struct Kept {
  std::int32_t calls;  // padding follows
  double last;
};

/// As a copy of a structure from the stack would.
void keep(Kept& kept, double last) {
  static std::atomic<int> rubbish = 0;
  const Kept next{kept.calls + 1, last};
  std::memset(static_cast<void*>(&kept), static_cast<int>(++rubbish), sizeof kept);
  kept.calls = next.calls;
  kept.last = next.last;
}

class PaddedMeasurement final : public faulty::Measurement {
 public:
  explicit PaddedMeasurement(const binnacle::Binding& binding)
      : Measurement(binding), kept_(declaration_.keeps<Kept>()) {}
  binnacle::Result linearize(const binnacle::MeasurementInput& in, binnacle::MeasurementOutput& out) const override {
    keep(in.memory[kept_], in.sample[range]);
    return Measurement::linearize(in, out);
  }

 private:
  binnacle::Memory<Kept> kept_;
};

class PaddedProcess final : public faulty::Process {
 public:
  explicit PaddedProcess(const binnacle::Binding& binding) : Process(binding), kept_(declaration_.keeps<Kept>()) {}
  binnacle::Result propagate(const binnacle::ProcessInput& in, binnacle::ProcessOutput& out) const override {
    keep(in.memory[kept_], in.x[p][0]);
    return Process::propagate(in, out);
  }

 private:
  binnacle::Memory<Kept> kept_;
};

class PaddedNoise final : public faulty::Noise {
 public:
  PaddedNoise(const binnacle::Binding& binding, const binnacle::NoiseBinding& noise)
      : Noise(binding, noise), kept_(declaration_.keeps<Kept>()) {}
  void estimate(const binnacle::Innovation& in, binnacle::MatrixView R) const override {
    Noise::estimate(in, R);
    keep(in.memory[kept_], R(0, 0));
    R(0, 0) *= 1 + 1e-9 * in.memory[kept_].calls;
  }

 private:
  binnacle::Memory<Kept> kept_;
};

}  // namespace

BINNACLE_PLUGIN("padded_memory", "1.0.0", registry) {
  registry.add<PaddedMeasurement>();
  registry.add<PaddedProcess>();
  registry.add<PaddedNoise>();
}
