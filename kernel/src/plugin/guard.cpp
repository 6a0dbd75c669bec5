// SPDX-License-Identifier: Apache-2.0
// The ABI guard compared field by field, with the remedy for each.
#include "plugin/guard.hpp"

#include <cstdio>
#include <type_traits>

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
constexpr std::size_t instruction_set_count = std::size(instruction_set_names);

std::string join(const std::vector<std::string>& words, const char* none) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text.empty() ? none : text;
}

std::string hex(std::uint64_t value) {
  char text[20];
  std::snprintf(text, sizeof text, "0x%016llx", static_cast<unsigned long long>(value));
  return text;
}

std::string instruction_sets_text(std::uint64_t bits) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < 64; ++i) {
    if (!(bits >> i & 1)) continue;
    words.push_back(i < instruction_set_count ? instruction_set_names[i] : "bit " + std::to_string(i));
  }
  return join(words, "none");
}

std::string sanitizers_text(std::uint32_t bits) {
  std::vector<std::string> words;
  if (bits & address_sanitizer) words.emplace_back("address");
  if (bits & thread_sanitizer) words.emplace_back("thread");
  if (bits & memory_sanitizer) words.emplace_back("memory");
  return join(words, "none");
}

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

std::string eigen_text(std::uint32_t version) {
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

std::string on_off(std::uint32_t value) { return value ? "on" : "off"; }

std::string layout_text(const TypeLayout& layout) {
  return "size " + std::to_string(layout.size) + ", alignment " + std::to_string(layout.align);
}

std::string sanitizer_remedy() {
  return host.sanitizers
             ? "rebuild the plugin with -fsanitize=" + std::string(host.sanitizers & thread_sanitizer   ? "thread"
                                                                   : host.sanitizers & memory_sanitizer ? "memory"
                                                                                                        : "address")
             : "rebuild the plugin without -fsanitize";
}

const std::string rebuild = "rebuild the plugin with this version's headers";

/// Collects the fields that differ.
class Comparison {
 public:
  template <class T, class Text>
  void field(const char* name, const T& host_value, const T& plugin_value, Severity severity, const Text& text,
             std::string remedy) {
    if (host_value == plugin_value) return;
    differences.push_back({name, text(host_value), text(plugin_value), severity, std::move(remedy)});
  }

  std::vector<Difference> differences;
};

const auto number = [](std::uint32_t value) { return std::to_string(value); };

void compare_types(const Guard& a, const Guard& b, std::vector<Difference>& differences) {
  for (std::size_t i = 0; i < type_count; ++i) {
    const TypeLayout& mine = a.types[i];
    const TypeLayout& other = b.types[i];
    if (mine.size == other.size && mine.align == other.align) continue;
    differences.push_back(
        {type_names[i], layout_text(mine), layout_text(other), Severity::refused, rebuild + " and compiler settings"});
  }
}

void compare_instruction_sets(const Guard& plugin, std::uint64_t supported, std::vector<Difference>& differences) {
  const std::uint64_t lacking = plugin.instruction_sets & ~supported;
  if (lacking == 0) return;
  differences.push_back({"instruction sets", "this processor lacks " + instruction_sets_text(lacking),
                         instruction_sets_text(plugin.instruction_sets), Severity::refused,
                         "rebuild the plugin for this processor, without -march=native from another one"});
}

}  // namespace

const Guard& guard_of_host() { return host; }

std::vector<Difference> compare(const Guard& a, const Guard& b, std::uint64_t host_supports) {
  using enum Severity;
  Comparison c;
  c.field("magic", a.magic, b.magic, refused, hex, "this is no Binnacle plugin; remove the file");
  if (!c.differences.empty()) return c.differences;
  c.field("size of the guard", a.size, b.size, refused, number, rebuild);
  c.field("API major", a.api_major, b.api_major, refused, number, rebuild);
  c.field("number of types", a.types_used, b.types_used, refused, number, rebuild);
  if (!c.differences.empty()) return c.differences;
  // What an older minor version has, a newer one has too.
  if (b.api_minor > a.api_minor)
    c.field("API minor", a.api_minor, b.api_minor, refused, number, "update this program, or " + rebuild);
  c.field("standard library", a.standard_library, b.standard_library, refused, standard_library_text,
          "rebuild the plugin with " + standard_library_text(a.standard_library));
  if (a.standard_library == b.standard_library && a.standard_library_abi != b.standard_library_abi) {
    c.differences.push_back({"ABI of the standard library", standard_library_abi_text(a), standard_library_abi_text(b),
                             refused, "rebuild the plugin with the host's setting"});
  }
  c.field("debug containers", a.debug_containers, b.debug_containers, refused, debug_containers_text,
          a.debug_containers ? "rebuild the plugin with the host's setting"
                             : "rebuild the plugin without _GLIBCXX_DEBUG");
  c.field("sanitizers", a.sanitizers, b.sanitizers, refused, sanitizers_text, sanitizer_remedy());
  compare_types(a, b, c.differences);
  compare_instruction_sets(b, host_supports, c.differences);
  c.field("header hash", a.header_hash, b.header_hash, headers_may_differ ? warned : refused, hex, rebuild);
  c.field("container assertions", a.container_assertions, b.container_assertions, warned, on_off,
          "none needed; _GLIBCXX_ASSERTIONS changes no layout");
  c.field("Eigen version", a.eigen_version, b.eigen_version, warned, eigen_text,
          "none needed; rebuild both with one Eigen if results differ");
  c.field("EIGEN_MAX_ALIGN_BYTES", a.eigen_max_align, b.eigen_max_align, warned, number,
          "none needed; no owning Eigen object crosses");
  c.field(
      "compiler", text_of(a.compiler), text_of(b.compiler), warned, [](const std::string& text) { return text; },
      "none needed; rebuild with one compiler if something is odd");
  return c.differences;
}

std::string to_string(const Difference& difference) {
  return difference.field + ": host " + difference.host + ", plugin " + difference.plugin + "; " + difference.remedy;
}

std::vector<std::pair<std::string, std::string>> fields_of(const Guard& guard) {
  return {{"guard", "binnacle_guard_v1, " + std::to_string(guard.size) + " bytes"},
          {"API", std::to_string(guard.api_major) + "." + std::to_string(guard.api_minor)},
          {"types", std::to_string(guard.types_used)},
          {"standard library", standard_library_text(guard.standard_library)},
          {"ABI of the standard library", standard_library_abi_text(guard)},
          {"debug containers", debug_containers_text(guard.debug_containers)},
          {"container assertions", on_off(guard.container_assertions)},
          {"sanitizers", sanitizers_text(guard.sanitizers)},
          {"instruction sets", instruction_sets_text(guard.instruction_sets)},
          {"Eigen version", eigen_text(guard.eigen_version)},
          {"EIGEN_MAX_ALIGN_BYTES", std::to_string(guard.eigen_max_align)},
          {"header hash", hex(guard.header_hash)},
          {"compiler", text_of(guard.compiler)}};
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
