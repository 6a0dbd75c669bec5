// SPDX-License-Identifier: Apache-2.0
// Breaks no rule: what it keeps has padding, whose bytes are whatever stood there, in no two objects the same.
// fails: nothing
#include <atomic>
#include <cstring>

#include "faulty.hpp"

namespace {

struct Kept {
  std::int32_t calls;  // padding follows
  double last;
};

class Subject final : public faulty::Noise {
 public:
  Subject(const binnacle::Binding& binding, const binnacle::NoiseBinding& noise)
      : Noise(binding, noise), kept_(declaration_.keeps<Kept>()) {}
  void estimate(const binnacle::Innovation& in, binnacle::MatrixView R) const override {
    Noise::estimate(in, R);
    Kept& kept = in.memory[kept_];
    const Kept next{kept.calls + 1, R(0, 0)};
    // As a copy of a structure from the stack would.
    std::memset(static_cast<void*>(&kept), static_cast<int>(++rubbish), sizeof kept);
    kept.calls = next.calls;
    kept.last = next.last;
    R(0, 0) *= 1 + 1e-9 * kept.calls;
  }

 private:
  static inline std::atomic<int> rubbish = 0;
  binnacle::Memory<Kept> kept_;
};

}  // namespace

BINNACLE_PLUGIN("padded_memory", "1.0.0", registry) { registry.add<Subject>(); }
