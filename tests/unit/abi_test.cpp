// SPDX-License-Identifier: Apache-2.0
// The ABI guard: what is compared, what is refused, what is said.
#include "plugin/library.hpp"

#include <algorithm>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "binnacle/catalog.hpp"
#include "binnacle/version.hpp"
#include "catch.hpp"

namespace abi_test {

using namespace binnacle;
using abi::Guard;

namespace {

constexpr std::uint64_t everything = ~0ull;

/// The differences that one change to a guard like the host's makes.
std::vector<abi::Difference> after(const std::function<void(Guard&)>& change, std::uint64_t processor = everything) {
  Guard plugin = abi::guard_of_host();
  change(plugin);
  return abi::compare(abi::guard_of_host(), plugin, processor);
}

void check_one(const std::function<void(Guard&)>& change, const std::string& field, abi::Severity severity) {
  const auto differences = after(change);
  INFO(field);
  REQUIRE(differences.size() == 1);
  CHECK(differences[0].field == field);
  CHECK(differences[0].severity == severity);
  CHECK(differences[0].host != differences[0].plugin);
  CHECK(!differences[0].remedy.empty());
}

}  // namespace

TEST_CASE("a guard agrees with itself", "[abi]") {
  CHECK(after([](Guard&) {}).empty());
  CHECK(abi::compare(abi::guard_of_host(), abi::guard_of_host(), abi::processor_instruction_sets()).empty());
}

TEST_CASE("a guard is made at compile time, of this file's settings", "[abi]") {
  static constexpr Guard guard = abi::make_guard("mine", "1.2");
  static_assert(guard.magic == abi::magic && guard.size == sizeof(Guard) && guard.types_used == abi::type_count);
  static_assert(guard.types[0].size == sizeof(std::string) && guard.types[1].align == alignof(std::vector<double>));
  CHECK(abi::text_of(guard.name) == "mine");
  CHECK(abi::text_of(guard.version) == "1.2");
  CHECK(std::memcmp(&guard.magic, "BINNACLE", 8) == 0);
}

TEST_CASE("what would corrupt memory is refused", "[abi]") {
  using enum abi::Severity;
  check_one([](Guard& g) { g.magic = 1; }, "magic", refused);
  check_one([](Guard& g) { g.size -= 8; }, "size of the guard", refused);
  check_one([](Guard& g) { ++g.api_major; }, "API major", refused);
  check_one([](Guard& g) { ++g.types_used; }, "number of types", refused);
  check_one([](Guard& g) { g.types[7].size += 8; }, "ComponentSpec", refused);
  check_one([](Guard& g) { g.types[7].align = 1; }, "ComponentSpec", refused);
  check_one([](Guard& g) { g.standard_library = 2; }, "standard library", refused);
  check_one([](Guard& g) { g.standard_library_abi ^= 1; }, "ABI of the standard library", refused);
  check_one([](Guard& g) { g.debug_containers ^= 1; }, "debug containers", refused);
  check_one([](Guard& g) { g.sanitizers ^= abi::thread_sanitizer; }, "sanitizers", refused);
}

TEST_CASE("a plugin that needs a newer API, or other headers before 1.0, is refused", "[abi]") {
  using enum abi::Severity;
  static_assert(BINNACLE_VERSION_MAJOR == 0);  // from 1.0 on, another header hash only warns
  check_one([](Guard& g) { ++g.api_minor; }, "API minor", refused);
  check_one([](Guard& g) { g.header_hash ^= 1; }, "header hash", refused);
}

TEST_CASE("an older minor version of the API is no difference", "[abi]") {
  Guard newer = abi::guard_of_host();
  ++newer.api_minor;
  CHECK(abi::compare(newer, abi::guard_of_host(), everything).empty());
}

TEST_CASE("what may differ is warned of", "[abi]") {
  using enum abi::Severity;
  check_one([](Guard& g) { g.eigen_version += 1; }, "Eigen version", warned);
  check_one([](Guard& g) { g.eigen_max_align *= 4; }, "EIGEN_MAX_ALIGN_BYTES", warned);
  check_one([](Guard& g) { g.compiler[0] = '?'; }, "compiler", warned);
  check_one([](Guard& g) { g.container_assertions ^= 1; }, "container assertions", warned);
}

TEST_CASE("an instruction set is refused only where this processor lacks it", "[abi]") {
  constexpr std::uint64_t avx512f = 1ull << 10;
  const auto change = [](Guard& g) { g.instruction_sets |= avx512f; };
  CHECK(after(change, everything).empty());
  const auto differences = after(change, everything & ~avx512f);
  REQUIRE(differences.size() == 1);
  CHECK(differences[0].text().find("instruction sets: host this processor lacks avx512f, plugin ") == 0);
  CHECK(differences[0].severity == abi::Severity::refused);
}

TEST_CASE("names and versions do not count as differences", "[abi]") {
  CHECK(after([](Guard& g) { g.name[0] = 'x', g.version[0] = '9'; }).empty());
}

TEST_CASE("every field of the host can be printed", "[abi]") {
  const auto fields = host_guard();
  CHECK(fields.size() == 13);
  CHECK(std::all_of(fields.begin(), fields.end(), [](const auto& field) { return !field.second.empty(); }));
}

}  // namespace abi_test
