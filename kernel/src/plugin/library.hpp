// SPDX-License-Identifier: Apache-2.0
// A plugin's shared library: as a file, before any of its code may run (library_file.cpp); its ABI guard against the
// host's, field by field (guard.cpp); who may change it (exposure.cpp); and loaded (loader.cpp).
#pragma once

#include <deque>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/open_file.hpp"
#include "binnacle/abi.hpp"
#include "binnacle/catalog.hpp"

namespace binnacle::abi {

enum class Severity { warned, refused };

/// One field in which host and plugin differ.
struct Difference {
  std::string field;
  std::string host;
  std::string plugin;
  Severity severity = Severity::refused;
  std::string remedy;  // one line

  /// "sizeof(ComponentSpec): host 400, plugin 392; rebuild …"
  std::string text() const { return field + ": host " + host + ", plugin " + plugin + "; " + remedy; }
};

/// What this program was compiled with.
const Guard& guard_of_host();

/// Nothing when they agree. Magic or size wrong: that alone, the rest being unreadable. `host_supports`: instruction
/// sets that this processor has.
std::vector<Difference> compare(const Guard& host, const Guard& plugin, std::uint64_t host_supports);

/// Instruction sets of the processor at hand, as bits of Guard::instruction_sets.
std::uint64_t processor_instruction_sets();

/// The text in a fixed array, which may lack its final zero.
template <std::size_t N>
std::string text_of(const char (&text)[N]) {
  const std::string_view view(text, N);
  return std::string(view.substr(0, view.find('\0')));
}

}  // namespace binnacle::abi

namespace binnacle::internal::plugin {

inline constexpr const char* guard_symbol = "binnacle_guard_v1";
inline constexpr const char* register_symbol = "binnacle_register_v1";
inline constexpr const char* types_symbol = "binnacle_types_v1";

struct LibraryFile {
  std::string unreadable;             // why it cannot be read as a library of this machine; "" when it can
  std::string other_guard;            // "binnacle_guard_v2" where there is one of another version
  std::vector<std::string> exported;  // symbols that other libraries could bind to
  std::optional<abi::Guard> guard;    // as it lies in the file; its unread tail is zero when it is a shorter one
  std::string types;                  // what BINNACLE_TYPES says; "" where there is none
  bool looks_beside = false;          // $ORIGIN in its run path
};

using base::OpenFile;

/// What was found of a folder, for all the libraries in it: every start looks at them.
struct FolderLook {
  std::string folder, exposure;
};
/// Who else could exchange the file, or a folder that it lies in (a sticky one may be written by all), and the remedy; ""
/// where nobody could.
std::string exposure(const OpenFile& file, const std::filesystem::path& path, FolderLook& look);
/// Linked on this machine and not changed since: binnacle_add_plugin() leaves inode and time of change in FILE.built, which
/// no archive can carry along.
bool is_built_here(const std::filesystem::path& path);

/// Reads the dynamic symbol table, which a stripped library has as well (Boost.DLL's library_info up to 1.8x reads the
/// static one, and bounds nothing). Never throws for what the file holds.
LibraryFile inspect_library(const OpenFile& file);

/// Of the library that the address is in, loaded from the file.
std::string build_of(const void* address, const std::filesystem::path& file);

/// What distinguishes the loaded library of a type from any other that was built: its build ID, which the linker makes of its
/// contents; without one a checksum of the file. Empty: it is linked into this program.
std::string contents_of(const ComponentType& type, const std::vector<PluginInfo>& plugins);

/// The plugins that there are already, in several lists.
using Others = std::initializer_list<const std::vector<PluginInfo>*>;

/// Checks a plugin file, its guard, and that no other is called the same; none of its code runs. Errors when it is refused.
std::optional<PluginInfo> examine_plugin(const std::filesystem::path& file, Others others, Diagnostics& diagnostics);
/// Checks one and loads it: lets it register, adds it to those that are loaded, and its types; nothing but errors in the
/// diagnostics when it is refused. One that lists its types waits if it may.
void take_plugin(const std::filesystem::path& file, FolderLook& look, bool may_wait, std::vector<PluginInfo>& waiting,
                 std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types, Diagnostics& diagnostics);
/// Loads one that waited; checked again, for another may lie there by now.
void load_waiting_plugin(const PluginInfo& plugin, std::vector<PluginInfo>& plugins, std::deque<ComponentType>& types,
                         Diagnostics& diagnostics);
/// The same of one that is no file.
void link_plugin(std::shared_ptr<const LinkedPlugin> plugin, std::vector<PluginInfo>& plugins,
                 std::deque<ComponentType>& types, Diagnostics& diagnostics);

}  // namespace binnacle::internal::plugin
