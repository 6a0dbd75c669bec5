// SPDX-License-Identifier: Apache-2.0
// Starts its memory each time otherwise.
// fails: life.repeatable
#include <random>

#include "faulty.hpp"

namespace {

class Subject final : public faulty::Noise {
 public:
  Subject(const binnacle::Binding& binding, const binnacle::NoiseBinding& noise)
      : Noise(binding, noise), offset_(declaration_.keeps<double>()) {}
  void estimate(const binnacle::Innovation& in, binnacle::MatrixView R) const override {
    Noise::estimate(in, R);
    R(0, 0) *= 1 + 1e-9 * in.memory[offset_];
  }

 private:
  void initialise(const binnacle::MemoryView& memory) const override {
    memory[offset_] = static_cast<double>(std::random_device()() % 1000);
  }
  binnacle::Memory<double> offset_;
};

}  // namespace

BINNACLE_PLUGIN("start_differs", "1.0.0", registry) { registry.add<Subject>(); }
