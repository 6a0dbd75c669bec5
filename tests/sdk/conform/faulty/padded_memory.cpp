// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: what its components keep has padding, whose bytes are whatever stood there, in no two objects the same.
// fails: nothing
// types: padded_measurement padded_process padded_noise
#include <atomic>
#include <cstring>

#include "faulty.hpp"

namespace faulty::padded_memory {

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

class PaddedMeasurement final : public Measurement {
 public:
  explicit PaddedMeasurement(const Binding& binding) : Measurement(binding), kept_(declaration_.keeps<Kept>()) {}
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override {
    keep(in.memory[kept_], in.sample[range]);
    return Measurement::linearize(in, out);
  }

 private:
  Memory<Kept> kept_;
};

class PaddedProcess final : public Process {
 public:
  explicit PaddedProcess(const Binding& binding) : Process(binding), kept_(declaration_.keeps<Kept>()) {}
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override {
    keep(in.memory[kept_], in.x[p][0]);
    return Process::propagate(in, out);
  }

 private:
  Memory<Kept> kept_;
};

class PaddedNoise final : public Noise {
 public:
  PaddedNoise(const Binding& binding, const NoiseBinding& noise)
      : Noise(binding, noise), kept_(declaration_.keeps<Kept>()) {}
  void estimate(const Innovation& in, MatrixView R) const override {
    Noise::estimate(in, R);
    keep(in.memory[kept_], R(0, 0));
    R(0, 0) *= 1 + 1e-9 * in.memory[kept_].calls;
  }

 private:
  Memory<Kept> kept_;
};

void add(Registry& registry) {
  registry.add<PaddedMeasurement>(named<PaddedMeasurement>("padded_measurement"));
  registry.add<PaddedProcess>(named<PaddedProcess>("padded_process"));
  registry.add<PaddedNoise>(named<PaddedNoise>("padded_noise"));
}

}  // namespace faulty::padded_memory
