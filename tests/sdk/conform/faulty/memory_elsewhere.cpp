// SPDX-License-Identifier: Apache-2.0
// Keeps its counter outside the memory it is handed, found by an address inside.
// fails: life.snapshot
#include "faulty.hpp"

namespace faulty::memory_elsewhere {

class Subject final : public Noise {
 public:
  Subject(const Binding& binding, const NoiseBinding& noise) : Noise(binding, noise) {
    is_begun = declaration_.keeps<std::uint64_t>();
  }
  void estimate(const Innovation& in, MatrixView R) const override {
    Noise::estimate(in, R);
    // Its own place is known by the address of the memory that it was handed.
    const auto address = reinterpret_cast<std::uintptr_t>(in.memory.data());
    static std::uintptr_t places[64] = {};
    static int counts[64] = {};
    int place = 0;
    while (place < 63 && places[place] != 0 && places[place] != address) ++place;
    if (places[place] == 0 || in.memory[is_begun] == 0) places[place] = address, counts[place] = 0;
    in.memory[is_begun] = 1;
    R(0, 0) *= 1 + 1e-9 * ++counts[place];
  }

 private:
  Memory<std::uint64_t> is_begun;
};

void add(Registry& registry) { registry.add<Subject>(named<Subject>("memory_elsewhere")); }

}  // namespace faulty::memory_elsewhere
