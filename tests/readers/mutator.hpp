// SPDX-License-Identifier: Apache-2.0
// Bytes of good files, damaged: flipped, cut, repeated, swapped.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <random>
#include <string>

namespace binnacle::test {

/// How many for each reader: BINNACLE_MUTATIONS, else 10 000.
inline int mutations() {
  const char* given = std::getenv("BINNACLE_MUTATIONS");
  return given ? std::atoi(given) : 10000;
}

/// Other damage than always: BINNACLE_MUTATION_SEED.
inline std::uint64_t mutation_seed() {
  const char* given = std::getenv("BINNACLE_MUTATION_SEED");
  return given ? std::strtoull(given, nullptr, 10) : 20260120;
}

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  /// One to eight changes of any kind.
  std::string operator()(std::string bytes) {
    for (std::size_t changes = 1 + below(8); changes > 0 && !bytes.empty(); --changes) change(bytes);
    return bytes;
  }

 private:
  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : random_() % limit; }

  void change(std::string& bytes) {
    const std::size_t at = below(bytes.size()), length = 1 + below(std::min<std::size_t>(64, bytes.size() - at));
    switch (below(8)) {
      case 0: bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8))); break;
      case 1: bytes[at] = static_cast<char>(below(256)); break;
      case 2: bytes.erase(at, length); break;
      case 3: bytes.insert(at, bytes.substr(at, length)); break;
      case 4: bytes.resize(at); break;
      case 5: bytes.insert(below(bytes.size()), bytes.substr(at, length)); break;
      case 6:
        for (std::size_t i = at; i < at + length; ++i) bytes[i] = static_cast<char>(below(256));
        break;
      default: {
        // A digit or a number of its own: what parsers stumble over.
        const char* const words[] = {
            "", "-", "99999999999999999999", "nan", "inf", "1e308", "-0", ".", "\n", ",", "*", "$", "\xB5\x62"};
        bytes.insert(at, words[below(std::size(words))]);
      }
    }
  }
  std::mt19937_64 random_;
};

}  // namespace binnacle::test
