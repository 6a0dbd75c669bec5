// SPDX-License-Identifier: Apache-2.0
// The ABI guard compared field by field, with the remedy for each.
#include "plugin/library.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <span>
#include <type_traits>

#include "binnacle/catalog.hpp"
#include "binnacle/version.hpp"

namespace binnacle::abi {

namespace {

static_assert(std::is_trivially_copyable_v<Guard> && std::is_standard_layout_v<Guard>);
static_assert(std::has_unique_object_representations_v<Guard>, "the guard has padding");

constexpr Guard host = make_guard("binnacle", "");

/// Before 1.0 any header may change without its API number: a virtual function more moves those behind it.
constexpr bool headers_may_differ = BINNACLE_VERSION_MAJOR >= 1;

#define BINNACLE_ABI_NAME(...) #__VA_ARGS__,
constexpr const char* type_names[] = {BINNACLE_ABI_TYPES(BINNACLE_ABI_NAME)};
#undef BINNACLE_ABI_NAME
static_assert(std::size(type_names) == type_count);

#define BINNACLE_ABI_NAME(macro, name) name,
constexpr const char* instruction_set_names[] = {BINNACLE_ABI_INSTRUCTION_SETS(BINNACLE_ABI_NAME)};
#undef BINNACLE_ABI_NAME
constexpr const char* sanitizer_names[] = {"address", "thread", "memory"};

std::string hex(std::uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "0x%016llx", static_cast<unsigned long long>(value));
  return text;
}

std::string bits_text(std::uint64_t bits, std::span<const char* const> names) {
  std::string text;
  for (std::size_t i = 0; i < 64; ++i)
    if (bits >> i & 1) text += (text.empty() ? "" : " ") + (i < names.size() ? names[i] : "bit " + std::to_string(i));
  return text.empty() ? "none" : text;
}

std::string instruction_sets_text(std::uint64_t bits) { return bits_text(bits, instruction_set_names); }
std::string sanitizers_text(std::uint32_t bits) { return bits_text(bits, sanitizer_names); }

std::string standard_library_text(std::uint32_t library) {
  return library == 1 ? "libstdc++" : library == 2 ? "libc++" : "another";
}

std::string standard_library_abi_text(const Guard& guard) {
  if (guard.standard_library != 1) return std::to_string(guard.standard_library_abi);
  std::string text = "_GLIBCXX_USE_CXX11_ABI=" + std::to_string(guard.standard_library_abi & 1);
  if (guard.standard_library_abi & 2) text += " with inline namespace";
  return text;
}

std::string debug_containers_text(std::uint32_t bits) {
  return bits == 0 ? "off" : bits == 1 ? "_GLIBCXX_DEBUG" : "on (" + std::to_string(bits) + ")";
}

std::string eigen_text(std::uint32_t v) {
  return std::to_string(v / 10000) + "." + std::to_string(v / 100 % 100) + "." + std::to_string(v % 100);
}

std::string on_off(std::uint32_t value) { return value ? "on" : "off"; }

std::string layout_text(const TypeLayout& layout) {
  return "size " + std::to_string(layout.size) + ", alignment " + std::to_string(layout.align);
}

/// But for the plugin's name and version, and what may differ without a word.
bool are_alike(const Guard& a, Guard b) {
  std::copy(std::begin(a.name), std::end(a.name), b.name);
  std::copy(std::begin(a.version), std::end(a.version), b.version);
  b.instruction_sets = a.instruction_sets;
  return std::memcmp(&a, &b, sizeof a) == 0;
}

std::string sanitizer_remedy(std::uint32_t bits) {
  if (!bits) return "rebuild the plugin without -fsanitize";
  return std::string("rebuild the plugin with -fsanitize=") + (bits & thread_sanitizer   ? "thread"
                                                               : bits & memory_sanitizer ? "memory"
                                                                                         : "address");
}

}  // namespace

const Guard& guard_of_host() { return host; }

std::vector<Difference> compare(const Guard& a, const Guard& b, std::uint64_t host_supports) {
  using enum Severity;
  if (are_alike(a, b) && (b.instruction_sets & ~host_supports) == 0) return {};
  const std::string rebuild = "rebuild the plugin with this version's headers";
  std::vector<Difference> differences;
  const auto differ = [&](const char* name, const std::string& mine, const std::string& other, Severity severity,
                          const std::string& remedy) {
    if (mine != other) differences.push_back({name, mine, other, severity, remedy});
  };
  differ("magic", hex(a.magic), hex(b.magic), refused, "this is not a Binnacle plugin; remove the file");
  if (!differences.empty()) return differences;
  differ("size of the guard", std::to_string(a.size), std::to_string(b.size), refused, rebuild);
  differ("API major", std::to_string(a.api_major), std::to_string(b.api_major), refused, rebuild);
  differ("number of types", std::to_string(a.types_used), std::to_string(b.types_used), refused, rebuild);
  if (!differences.empty()) return differences;
  // What an older minor version has, a newer one has too.
  if (b.api_minor > a.api_minor)
    differ("API minor", std::to_string(a.api_minor), std::to_string(b.api_minor), refused,
           "update this program, or " + rebuild);
  differ("standard library", standard_library_text(a.standard_library), standard_library_text(b.standard_library),
         refused, "rebuild the plugin with " + standard_library_text(a.standard_library));
  if (a.standard_library == b.standard_library)
    differ("ABI of the standard library", standard_library_abi_text(a), standard_library_abi_text(b), refused,
           "rebuild the plugin with the host's setting");
  differ("debug containers", debug_containers_text(a.debug_containers), debug_containers_text(b.debug_containers),
         refused,
         a.debug_containers ? "rebuild the plugin with the host's setting"
                            : "rebuild the plugin without _GLIBCXX_DEBUG");
  differ("sanitizers", sanitizers_text(a.sanitizers), sanitizers_text(b.sanitizers), refused,
         sanitizer_remedy(a.sanitizers));
  for (std::size_t i = 0; i < type_count; ++i)
    differ(type_names[i], layout_text(a.types[i]), layout_text(b.types[i]), refused,
           rebuild + " and compiler settings");
  if (const std::uint64_t lacking = b.instruction_sets & ~host_supports)
    differ("instruction sets", "this processor lacks " + instruction_sets_text(lacking),
           instruction_sets_text(b.instruction_sets), refused,
           "rebuild the plugin for this processor, without -march=native from another one");
  differ("header hash", hex(a.header_hash), hex(b.header_hash), headers_may_differ ? warned : refused, rebuild);
  differ("container assertions", on_off(a.container_assertions), on_off(b.container_assertions), warned,
         "none needed; _GLIBCXX_ASSERTIONS changes no layout");
  differ("Eigen version", eigen_text(a.eigen_version), eigen_text(b.eigen_version), warned,
         "none needed; rebuild both with one Eigen if results differ");
  differ("EIGEN_MAX_ALIGN_BYTES", std::to_string(a.eigen_max_align), std::to_string(b.eigen_max_align), warned,
         "none needed; no owning Eigen object crosses");
  differ("compiler", text_of(a.compiler), text_of(b.compiler), warned,
         "none needed; rebuild with one compiler if results are unexpected");
  return differences;
}

std::uint64_t processor_instruction_sets() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_cpu_init();
  std::uint64_t bits = 0;
  std::size_t i = 0;
  // Literals only: the builtin takes nothing else.
#define BINNACLE_ABI_SUPPORTED(macro, name) \
  bits |= static_cast<std::uint64_t>(__builtin_cpu_supports(name) != 0) << i++;
  BINNACLE_ABI_INSTRUCTION_SETS(BINNACLE_ABI_SUPPORTED)
#undef BINNACLE_ABI_SUPPORTED
  return bits;
#else
  return ~0ull;  // guards of other processors carry no bits
#endif
}

}  // namespace binnacle::abi

namespace binnacle {

std::vector<std::pair<std::string, std::string>> host_guard() {
  using namespace abi;
  return {{"guard", "binnacle_guard_v1, " + std::to_string(host.size) + " bytes"},
          {"API", std::to_string(host.api_major) + "." + std::to_string(host.api_minor)},
          {"types", std::to_string(host.types_used)},
          {"standard library", standard_library_text(host.standard_library)},
          {"ABI of the standard library", standard_library_abi_text(host)},
          {"debug containers", debug_containers_text(host.debug_containers)},
          {"container assertions", on_off(host.container_assertions)},
          {"sanitizers", sanitizers_text(host.sanitizers)},
          {"instruction sets", instruction_sets_text(host.instruction_sets)},
          {"Eigen version", eigen_text(host.eigen_version)},
          {"EIGEN_MAX_ALIGN_BYTES", std::to_string(host.eigen_max_align)},
          {"header hash", hex(host.header_hash)},
          {"compiler", text_of(host.compiler)}};
}

}  // namespace binnacle
