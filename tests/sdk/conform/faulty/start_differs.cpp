// SPDX-License-Identifier: Apache-2.0
// Starts its memory each time otherwise.
// fails: life.repeatable
#include <random>

#include "faulty.hpp"

namespace faulty::start_differs {

class Subject final : public Noise {
 public:
  Subject(const Binding& binding, const NoiseBinding& noise)
      : Noise(binding, noise), offset_(declaration_.keeps<double>()) {}
  void estimate(const Innovation& in, MatrixView R) const override {
    Noise::estimate(in, R);
    R(0, 0) *= 1 + 1e-9 * in.memory[offset_];
  }

 private:
  void initialise(const MemoryView& memory) const override {
    memory[offset_] = static_cast<double>(std::random_device()() % 1000);
  }
  Memory<double> offset_;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("start_differs")); }

}  // namespace faulty::start_differs
