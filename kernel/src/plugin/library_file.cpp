// SPDX-License-Identifier: Apache-2.0
// Reading the guard out of an ELF file (System V ABI, gABI chapters 4 and 5), every offset checked against the file.
#include <elf.h>

#include <link.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "plugin/library.hpp"

namespace binnacle::internal::plugin {

namespace {

using Header = ElfW(Ehdr);
using Segment = ElfW(Phdr);
using Section = ElfW(Shdr);
using Symbol = ElfW(Sym);

constexpr int native_class = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
constexpr std::size_t largest_table = std::size_t{1} << 28;  // of a file that lies about its sizes

constexpr std::size_t longest_list = std::size_t{1} << 20;

struct Unreadable {
  std::string why;
};
constexpr const char* damaged = "it is damaged or truncated";

/// All libraries of a folder are looked at by every start, so it reads little: the head, where the linker puts the dynamic
/// tables of a small library, at once, and what lies elsewhere piece by piece.
class Reader {
 public:
  explicit Reader(const OpenFile& file) : file_(file.id), size_(static_cast<std::size_t>(file.status.st_size)) {
    if (!read_file(0, head_.data(), std::min(size_, head_.size()))) size_ = 0;
  }

  std::size_t size() const { return size_; }

  bool read(std::size_t offset, void* to, std::size_t bytes) const {
    if (offset > size_ || bytes > size_ - offset) return false;
    if (offset + bytes > head_.size()) return read_file(offset, to, bytes);
    if (bytes > 0) std::memcpy(to, head_.data() + offset, bytes);
    return true;
  }

  template <class T>
  std::vector<T> table(std::size_t offset, std::size_t bytes) const {
    if (bytes > std::min(size_, largest_table)) throw Unreadable{damaged};
    std::vector<T> items(bytes / sizeof(T));
    if (!read(offset, items.data(), items.size() * sizeof(T))) throw Unreadable{damaged};
    return items;
  }

 private:
  bool read_file(std::size_t offset, void* to, std::size_t bytes) const {
    for (std::size_t done = 0; done < bytes;) {
      const auto got = ::pread(file_, static_cast<char*>(to) + done, bytes - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return false;
      done += static_cast<std::size_t>(got);
    }
    return true;
  }

  int file_;
  std::size_t size_;
  std::array<char, 4096> head_{};
};

/// The machine that this program was built for is that of its own header.
Header own_header() {
  const OpenFile file("/proc/self/exe");
  Header own{};
  if (!Reader(file).read(0, &own, sizeof own))
    throw Unreadable{"the program's own file cannot be read" + (file.failure.empty() ? "" : ": " + file.failure)};
  return own;
}

Header read_header(const Reader& reader) {
  static const Header own = own_header();
  Header header{};
  if (!reader.read(0, &header, sizeof header))
    throw Unreadable{reader.size() == 0 ? "it cannot be read, or is empty" : "it is not a shared library (too short)"};
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) throw Unreadable{"it is not a shared library (not ELF)"};
  if (header.e_ident[EI_CLASS] != native_class || header.e_ident[EI_DATA] != own.e_ident[EI_DATA] ||
      header.e_machine != own.e_machine)
    throw Unreadable{"it is built for another machine"};
  if (header.e_type != ET_DYN || header.e_phentsize != sizeof(Segment) || header.e_shentsize != sizeof(Section))
    throw Unreadable{"it is not a shared library"};
  return header;
}

bool is_exported(const Symbol& symbol) {
  const int binding = symbol.st_info >> 4;
  return symbol.st_shndx != SHN_UNDEF && (binding == STB_GLOBAL || binding == STB_WEAK);
}

/// The bytes that the loader would put at the symbol's address, `most` at most; none where they do not lie in the file.
std::string bytes_of(const Reader& reader, const std::vector<Segment>& segments, const Symbol& symbol,
                     std::size_t most) {
  for (const Segment& segment : segments) {
    const std::size_t shift = symbol.st_value - segment.p_vaddr;  // beyond the segment's size if it begins behind
    if (segment.p_type != PT_LOAD || shift >= segment.p_filesz) continue;
    std::string bytes(std::min({most, std::size_t{symbol.st_size}, std::size_t{segment.p_filesz} - shift}), '\0');
    return reader.read(segment.p_offset + shift, bytes.data(), bytes.size()) ? bytes : "";
  }
  return "";
}

abi::Guard guard_in(const std::string& bytes) {
  abi::Guard guard{};
  std::memcpy(&guard, bytes.data(), std::min(bytes.size(), sizeof guard));
  return guard;
}

}  // namespace

LibraryFile inspect_library(const OpenFile& file) {
  LibraryFile result;
  try {
    const Reader reader(file);
    const Header header = read_header(reader);
    const auto segments = reader.table<Segment>(header.e_phoff, header.e_phnum * sizeof(Segment));
    const auto sections = reader.table<Section>(header.e_shoff, header.e_shnum * sizeof(Section));
    for (const Section& section : sections) {
      if (section.sh_type != SHT_DYNSYM) continue;
      if (section.sh_link >= sections.size()) throw Unreadable{damaged};
      const Section& texts = sections[section.sh_link];
      const auto names = reader.table<char>(texts.sh_offset, texts.sh_size);
      const std::string_view all(names.data(), names.size());
      result.looks_beside = all.find("$ORIGIN") != all.npos || all.find("${ORIGIN}") != all.npos;
      for (const Symbol& symbol : reader.table<Symbol>(section.sh_offset, section.sh_size)) {
        if (!is_exported(symbol) || symbol.st_name >= names.size()) continue;
        const char* start = names.data() + symbol.st_name;
        const std::string name(start, strnlen(start, names.size() - symbol.st_name));
        result.exported.push_back(name);
        if (name == guard_symbol) {
          if (const auto bytes = bytes_of(reader, segments, symbol, sizeof(abi::Guard)); !bytes.empty())
            result.guard = guard_in(bytes);
        } else if (name == types_symbol) {
          const auto bytes = bytes_of(reader, segments, symbol, longest_list);
          result.types = bytes.c_str();
        } else if (name.starts_with("binnacle_guard_v")) {
          result.other_guard = name;
        }
      }
    }
  } catch (const Unreadable& found) {
    result.unreadable = found.why;
  }
  return result;
}

}  // namespace binnacle::internal::plugin
