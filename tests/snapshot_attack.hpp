// SPDX-License-Identifier: Apache-2.0
// Snapshots that are damaged, by chance or on purpose: for tests, and for a fuzz target.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "binnacle/session.hpp"
#include "binnacle/state_block.hpp"
#include "run/checksum.hpp"

namespace snapshot_attack {

using namespace binnacle;
using Bytes = std::vector<std::byte>;

/// As session.cpp has it.
struct Head {
  char magic[8];
  std::uint64_t composition, size, checksum;
};

inline Bytes snapshot_of(const Session& session) {
  Bytes bytes(session.snapshot_size());
  session.snapshot(bytes);
  return bytes;
}

/// Puts right what the head says of the rest, as whoever means harm would: what is behind it is as it was.
inline void reseal(Bytes& snapshot) {
  if (snapshot.size() < sizeof(Head)) return;
  Head head;
  std::memcpy(&head, snapshot.data(), sizeof head);
  const auto payload = std::span<const std::byte>(snapshot).subspan(sizeof head);
  head.size = payload.size();
  head.checksum = internal::runtime::checksum_of(head, payload);
  std::memcpy(snapshot.data(), &head, sizeof head);
}

/// One kind of damage, never none: bits flipped, a part gone, two parts exchanged, bytes more, a number that is special.
inline Bytes damaged(const Bytes& whole, std::mt19937_64& random, std::size_t from = 0) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % std::max<std::size_t>(n, 1)); };
  Bytes bytes = whole;
  while (bytes == whole) {
    switch (below(5)) {
      case 0:
        for (std::size_t flips = 1 + below(4); flips > 0; --flips)
          bytes[from + below(bytes.size() - from)] ^= std::byte{1} << static_cast<int>(below(8));
        break;
      case 1: {
        const std::size_t at = from + below(bytes.size() - from), count = 1 + below(bytes.size() - at);
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    bytes.begin() + static_cast<std::ptrdiff_t>(at + count));
        break;
      }
      case 2: {
        const std::size_t words = (bytes.size() - from) / 8;
        if (words < 2) break;
        std::byte* const a = bytes.data() + from + 8 * below(words);
        std::byte* const b = bytes.data() + from + 8 * below(words);
        if (a != b) std::swap_ranges(a, a + 8, b);
        break;
      }
      case 3: {
        const std::size_t at = from + below(bytes.size() - from + 1);
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), 1 + below(64), std::byte(random()));
        break;
      }
      default: {
        static constexpr std::uint64_t special[] = {0,
                                                    1,
                                                    2,
                                                    ~std::uint64_t{0},
                                                    std::uint64_t{1} << 63,
                                                    (std::uint64_t{1} << 63) - 1,
                                                    std::uint64_t{1} << 31,
                                                    0x7ff0000000000000u,
                                                    0x7ff8000000000000u,
                                                    0x7fefffffffffffffu};
        const std::uint64_t number = special[below(std::size(special))];
        const std::size_t size = below(2) == 0 ? 4 : 8;
        if (bytes.size() < from + size) break;
        std::memcpy(bytes.data() + from + below((bytes.size() - from) / size) * size, &number, size);
      }
    }
  }
  return bytes;
}

/// Whether the session takes them. Where it does not, it is what it was, to the bit.
inline bool is_taken(Session& session, const Bytes& bytes) {
  const Bytes before = snapshot_of(session);
  try {
    session.restore(bytes);
    return true;
  } catch (const ConfigError& error) {
    if (error.diagnostics().items().front().code != "B082") throw;
  }
  if (snapshot_of(session) != before) throw std::logic_error("a refused snapshot changed the session");
  return false;
}

/// A payload is changed and sealed again: it is refused, or the session goes on with it, `go_on`, and shows all that it has.
template <class GoOn>
bool survives_forged(Session& session, const Bytes& whole, std::mt19937_64& random, GoOn&& go_on) {
  Bytes bytes = damaged(whole, random, sizeof(Head));
  if (bytes.size() > whole.size() || random() % 4 > 0) bytes.resize(whole.size());  // mostly of the right length
  reseal(bytes);
  if (!is_taken(session, bytes)) return false;
  go_on(session);
  for (int f = 0; f < static_cast<int>(session.composition().filters().size()); ++f) {
    const FilterInfo& filter = session.composition().filters()[static_cast<std::size_t>(f)];
    session.verdict({f});
    session.doubts({f});
    session.diagnosis({f});
    session.counts(FilterId{f});
    for (int m = 0; m < static_cast<int>(filter.measurements.size()); ++m) session.counts(MeasurementId{{f}, m});
    for (int b = 0; b < static_cast<int>(filter.blocks.size()); ++b) {
      std::vector<double> outputs(filter.blocks[static_cast<std::size_t>(b)].declaration->outputs.size());
      session.read({{f}, b}, outputs);
      session.read_sigma({{f}, b}, outputs);
    }
  }
  return true;
}

}  // namespace snapshot_attack
