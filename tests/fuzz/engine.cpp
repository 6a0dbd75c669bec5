// SPDX-License-Identifier: Apache-2.0
// A target as libFuzzer calls it.
#include <cstdint>
#include <string_view>

#include "target.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t capacity);

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  binnacle::fuzz::try_bytes({reinterpret_cast<const char*>(data), size});
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t capacity,
                                               unsigned seed) {
  char* const text = reinterpret_cast<char*>(data);
  const std::size_t made = binnacle::fuzz::mutate({text, size}, seed, text, capacity);
  return made > 0 ? made : LLVMFuzzerMutate(data, size, capacity);
}
