// SPDX-License-Identifier: Apache-2.0
// The random engine: published vectors, streams, plain memory, and deviates that are the same on every
// platform.
#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <type_traits>

#include "catch.hpp"
#include "random/normal.hpp"
#include "random/philox.hpp"

namespace random_test {

using namespace binnacle::random;

namespace {

using Counter = std::array<std::uint32_t, 4>;
using Key = std::array<std::uint32_t, 2>;

static_assert(std::uniform_random_bit_generator<Philox>);
static_assert(std::is_trivially_copyable_v<Philox> && std::is_standard_layout_v<Philox> && sizeof(Philox) == 32);

}  // namespace

// Random123, tests/kat_vectors, lines "philox4x32 10".
TEST_CASE("Philox4x32-10 gives the published answers") {
  REQUIRE(philox4x32_10(Counter{0, 0, 0, 0}, Key{0, 0}) == Counter{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  REQUIRE(philox4x32_10(Counter{0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, Key{0xffffffff, 0xffffffff}) ==
          Counter{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  REQUIRE(philox4x32_10(Counter{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, Key{0xa4093822, 0x299f31d0}) ==
          Counter{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

// C++26 [rand.predef]: the 10000th invocation of a default-constructed philox4x32 (seed 20111115) gives
// 1955073260.
TEST_CASE("the words of a stream are those of std::philox4x32 where both count alike") {
  Philox engine{20111115, 0, 0, 0};
  engine.discard(4999);
  REQUIRE(static_cast<std::uint32_t>(engine() >> 32) == 1955073260u);
}

TEST_CASE("a stream is cut from the published blocks, low half first") {
  Philox engine{.seed = 0x299f31d0a4093822u,
                .stream = 0x0370734413198a2eu,
                .position = 2 * 0x05a308d3243f6a88u,
                .spare = 0};
  const auto words = philox4x32_10({0x243f6a88, 0x05a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0});
  REQUIRE(engine() == (words[0] | std::uint64_t{words[1]} << 32));
  REQUIRE(engine() == (words[2] | std::uint64_t{words[3]} << 32));
}

TEST_CASE("names are hashed by FNV-1a") {
  REQUIRE(stream_number("") == 0xcbf29ce484222325u);
  REQUIRE(stream_number("a") == 0xaf63dc4c8601ec8cu);
  REQUIRE(stream_number("foobar") == 0x85944171f73967e8u);
}

TEST_CASE("a copy of the bytes continues like the original, and discard jumps") {
  auto engine = stream(7, "gyro.noise");
  for (int i = 0; i < 13; ++i) engine();
  std::array<std::byte, sizeof(Philox)> bytes{};
  std::memcpy(bytes.data(), &engine, sizeof engine);
  auto jumped = stream(7, "gyro.noise");
  jumped.discard(13);
  REQUIRE(jumped == engine);
  Philox restored;
  std::memcpy(&restored, bytes.data(), sizeof restored);
  for (int i = 0; i < 9; ++i) {
    const auto expected = engine();
    REQUIRE(restored() == expected);
    REQUIRE(jumped() == expected);
  }
}

TEST_CASE("streams and seeds do not resemble each other") {
  const auto correlation = [](Philox a, Philox b) {
    double sum = 0.0;
    for (int i = 0; i < 10000; ++i) sum += normal(a) * normal(b);
    return sum / 10000.0;
  };
  const double band = 4.0 / std::sqrt(10000.0);
  REQUIRE(std::abs(correlation(stream(1, "a"), stream(1, "b"))) < band);
  REQUIRE(std::abs(correlation(stream(1, "a"), stream(2, "a"))) < band);
  REQUIRE(std::abs(correlation(stream(1, "a"), stream(std::uint64_t{1} << 63 | 1, "a"))) < band);
}

TEST_CASE("normal deviates are the recorded ones") {
  auto engine = stream(42, "test");
  const std::array<double, 6> expected = {0x1.1207f09fc85acp-3,  -0x1.07e7cb265f172p-2, 0x1.0866d0438e603p-5,
                                          -0x1.4b72dfc67ccfbp+0, -0x1.a7696b05c8ef4p-1, 0x1.a28566ce8d3c7p-1};
  for (const double value : expected) REQUIRE(normal(engine) == value);
}

TEST_CASE("normal deviates have the moments of N(0, 1)") {
  auto engine = stream(1, "moments");
  constexpr int n = 200000;
  std::array<double, 5> moment{};
  int beyond_two = 0;
  for (int i = 0; i < n; ++i) {
    const double x = normal(engine);
    double power = 1.0;
    for (double& m : moment) m += (power *= x) / n;
    beyond_two += std::abs(x) > 2.0 ? 1 : 0;
  }
  const double root_n = std::sqrt(double{n});
  REQUIRE(std::abs(moment[0]) < 4.0 / root_n);
  REQUIRE(std::abs(moment[1] - 1.0) < 4.0 * std::sqrt(2.0) / root_n);
  REQUIRE(std::abs(moment[2]) < 4.0 * std::sqrt(15.0) / root_n);
  REQUIRE(std::abs(moment[3] - 3.0) < 4.0 * std::sqrt(96.0) / root_n);
  REQUIRE(std::abs(beyond_two / double{n} - 0.0455003) < 4.0 * std::sqrt(0.0434) / root_n);
}

}  // namespace random_test
