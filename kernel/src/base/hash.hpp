// SPDX-License-Identifier: Apache-2.0
// Hashes: of what a composition is, and of what keys a random stream.
#pragma once

#include <cstdint>
#include <string_view>

namespace binnacle::internal::base {

/// FNV-1a of bytes, 64 bits.
class Fnv1a {
 public:
  constexpr explicit Fnv1a(std::uint64_t start = 14695981039346656037ull) : value_(start) {}
  constexpr void add(std::string_view text) {
    for (const char c : text) add(static_cast<unsigned char>(c));
  }
  /// Its bytes, the lowest first.
  constexpr void add(std::uint64_t number) {
    for (int i = 0; i < 8; ++i) add(static_cast<unsigned char>(number >> (8 * i) & 0xff));
  }
  constexpr std::uint64_t value() const { return value_; }

 private:
  constexpr void add(unsigned char byte) { value_ = (value_ ^ byte) * 1099511628211ull; }
  std::uint64_t value_;
};

/// A 64-bit seed of a component's own, from (seed, run, JSON pointer).
constexpr std::uint64_t stream_seed(std::uint64_t seed, int run, std::string_view pointer) {
  Fnv1a hash(1469598103934665603ull);  // not the usual start; kept, since every recorded run hangs on it
  hash.add(seed);
  hash.add(static_cast<std::uint64_t>(run));
  hash.add(pointer);
  // FNV's low bits are weak; after splitmix64's finalizer every bit depends on every bit.
  std::uint64_t number = hash.value() + 0x9e3779b97f4a7c15ull;
  number = (number ^ (number >> 30)) * 0xbf58476d1ce4e5b9ull;
  number = (number ^ (number >> 27)) * 0x94d049bb133111ebull;
  return number ^ (number >> 31);
}

}  // namespace binnacle::internal::base
