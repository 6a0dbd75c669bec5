// SPDX-License-Identifier: Apache-2.0
// A random engine whose whole state is plain memory, with named streams: Philox4x32-10. Header-only.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>

namespace binnacle::random {

/// The keyed bijection of J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy as 1,
/// 2, 3", SC'11, section 3.3, doi:10.1145/2063384.2063405, with ten rounds. Integers only: the same everywhere.
constexpr std::array<std::uint32_t, 4> philox4x32_10(std::array<std::uint32_t, 4> counter,
                                                     std::array<std::uint32_t, 2> key) noexcept {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t p1 = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(p1 >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(p1),
               static_cast<std::uint32_t>(p0 >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(p0)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

/// A random engine (UniformRandomBitGenerator, 64 bits a draw) over the blocks of one stream.
///
///     random::Philox noise = random::stream(seed, "gyro");   // in initialise(); keep it in memory
///     const double u = random::uniform(noise);               // in the loop
///
/// Plain memory: it may be copied as bytes, lie in the kernel's arena, and a copy continues like the
/// original. The words of a stream are the Philox blocks at counters (0, stream), (1, stream), …, low half
/// first, under the key `seed`. The bijection makes blocks of one seed distinct; a stream lasts 2^65 draws.
struct Philox {
  using result_type = std::uint64_t;  ///< of one draw

  std::uint64_t seed;      // the key
  std::uint64_t stream;    // the upper half of the counter
  std::uint64_t position;  // draws made so far
  std::uint64_t spare;     // second half of the current block, while position is odd

  static constexpr result_type min() noexcept { return 0; }
  static constexpr result_type max() noexcept { return std::numeric_limits<result_type>::max(); }

  constexpr result_type operator()() noexcept {
    if (position++ % 2 == 1) return spare;
    const auto words = block((position - 1) / 2);
    spare = words[1];
    return words[0];
  }

  /// As after `draws` calls, at no cost.
  constexpr void discard(std::uint64_t draws) noexcept {
    position += draws;
    if (position % 2 == 1) spare = block(position / 2)[1];
  }

  friend constexpr bool operator==(const Philox& a, const Philox& b) noexcept {
    return a.seed == b.seed && a.stream == b.stream && a.position == b.position;
  }

 private:
  constexpr std::array<std::uint64_t, 2> block(std::uint64_t index) const noexcept {
    const auto low = [](std::uint64_t word) { return static_cast<std::uint32_t>(word); };
    const auto high = [](std::uint64_t word) { return static_cast<std::uint32_t>(word >> 32); };
    const auto w = philox4x32_10({low(index), high(index), low(stream), high(stream)}, {low(seed), high(seed)});
    return {w[0] | std::uint64_t{w[1]} << 32, w[2] | std::uint64_t{w[3]} << 32};
  }
};

/// FNV-1a, 64 bits: turns the name of a stream into its number.
constexpr std::uint64_t stream_number(std::string_view name) noexcept {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char character : name) hash = (hash ^ static_cast<unsigned char>(character)) * 0x100000001b3u;
  return hash;
}

/// The stream called `name` of `seed`, from its beginning. What is drawn from it changes with no other stream's use.
constexpr Philox stream(std::uint64_t seed, std::string_view name) noexcept {
  return {seed, stream_number(name), 0, 0};
}

/// Uniform in [0, 1), 53 bits: one draw.
constexpr double uniform(Philox& engine) noexcept { return static_cast<double>(engine() >> 11) * 0x1p-53; }

}  // namespace binnacle::random
