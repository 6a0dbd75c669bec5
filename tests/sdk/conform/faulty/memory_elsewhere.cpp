// SPDX-License-Identifier: Apache-2.0
// Keeps its counter outside the memory it is handed, found by an address inside.
// fails: life.snapshot
#include "faulty.hpp"

namespace {

class Subject final : public faulty::Noise {
 public:
  using Noise::Noise;
  std::size_t memory_bytes() const noexcept override { return Noise::memory_bytes() + sizeof(double*); }
  void start(std::byte* memory) const override {
    const std::uint64_t none = 0;
    std::memcpy(memory + Noise::memory_bytes(), &none, sizeof none);
  }
  void estimate(const binnacle::Innovation& innovation, std::byte* memory, binnacle::MatrixView R) const override {
    Noise::estimate(innovation, memory, R);
    // Its own place is known by the address of the memory that it was handed.
    const auto address = reinterpret_cast<std::uintptr_t>(memory);
    static std::uintptr_t places[64] = {};
    static int counts[64] = {};
    int place = 0;
    while (place < 63 && places[place] != 0 && places[place] != address) ++place;
    if (places[place] == 0 || std::memcmp(memory + Noise::memory_bytes(), "\0\0\0\0", 4) == 0)
      places[place] = address, counts[place] = 0;
    const std::uint32_t one = 1;
    std::memcpy(memory + Noise::memory_bytes(), &one, sizeof one);
    R(0, 0) *= 1 + 1e-9 * ++counts[place];
  }
};

}  // namespace

BINNACLE_PLUGIN("memory_elsewhere", "1.0.0", registry) { registry.add<Subject>(); }
