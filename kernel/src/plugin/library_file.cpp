// SPDX-License-Identifier: Apache-2.0
// Reading the guard out of an ELF file (System V ABI, gABI chapters 4 and 5), every offset checked against the file.
#include <elf.h>

#include <link.h>
#include <algorithm>
#include <cstring>
#include <fstream>

#include "plugin/library.hpp"

namespace binnacle::internal::plugin {

namespace {

using Header = ElfW(Ehdr);
using Segment = ElfW(Phdr);
using Section = ElfW(Shdr);
using Symbol = ElfW(Sym);

constexpr int native_class = sizeof(void*) == 8 ? ELFCLASS64 : ELFCLASS32;
constexpr std::size_t largest_table = std::size_t{1} << 28;  // of a file that lies about its sizes

struct Unreadable {
  const char* why;
};
constexpr const char* damaged = "it is damaged or cut short";

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : stream_(file, std::ios::binary) {
    stream_.seekg(0, std::ios::end);
    const auto end = stream_.tellg();
    size_ = stream_ && end > 0 ? static_cast<std::size_t>(end) : 0;
  }

  std::size_t size() const { return size_; }

  bool read(std::size_t offset, void* to, std::size_t bytes) {
    if (offset > size_ || bytes > size_ - offset) return false;
    stream_.seekg(static_cast<std::streamoff>(offset));
    return static_cast<bool>(stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes)));
  }

  template <class T>
  std::vector<T> table(std::size_t offset, std::size_t bytes) {
    if (bytes > std::min(size_, largest_table)) throw Unreadable{damaged};
    std::vector<T> items(bytes / sizeof(T));
    if (!read(offset, items.data(), items.size() * sizeof(T))) throw Unreadable{damaged};
    return items;
  }

 private:
  std::ifstream stream_;
  std::size_t size_ = 0;
};

Header read_header(Reader& reader) {
  Header header{}, own{};  // the machine that this program was built for is that of its own header
  std::ifstream("/proc/self/exe", std::ios::binary).read(reinterpret_cast<char*>(&own), sizeof own);
  if (!reader.read(0, &header, sizeof header))
    throw Unreadable{reader.size() == 0 ? "it cannot be read, or is empty" : "it is no shared library (too short)"};
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0) throw Unreadable{"it is no shared library (not an ELF file)"};
  if (header.e_ident[EI_CLASS] != native_class || header.e_ident[EI_DATA] != own.e_ident[EI_DATA] ||
      header.e_machine != own.e_machine)
    throw Unreadable{"it is built for another machine"};
  if (header.e_type != ET_DYN || header.e_phentsize != sizeof(Segment) || header.e_shentsize != sizeof(Section))
    throw Unreadable{"it is no shared library"};
  return header;
}

bool is_exported(const Symbol& symbol) {
  const int binding = symbol.st_info >> 4;
  return symbol.st_shndx != SHN_UNDEF && (binding == STB_GLOBAL || binding == STB_WEAK);
}

/// The bytes that the loader would put at the symbol's address.
std::optional<abi::Guard> read_guard(Reader& reader, const std::vector<Segment>& segments, const Symbol& symbol) {
  for (const Segment& segment : segments) {
    const std::size_t shift = symbol.st_value - segment.p_vaddr;  // beyond the segment's size if it begins behind
    if (segment.p_type != PT_LOAD || shift >= segment.p_filesz) continue;
    abi::Guard guard{};
    const std::size_t bytes =
        std::min({sizeof guard, std::size_t{symbol.st_size}, std::size_t{segment.p_filesz} - shift});
    return reader.read(segment.p_offset + shift, &guard, bytes) ? std::optional(guard) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

LibraryFile inspect_library(const std::filesystem::path& file) {
  LibraryFile result;
  try {
    Reader reader(file);
    const Header header = read_header(reader);
    const auto segments = reader.table<Segment>(header.e_phoff, header.e_phnum * sizeof(Segment));
    const auto sections = reader.table<Section>(header.e_shoff, header.e_shnum * sizeof(Section));
    for (const Section& section : sections) {
      if (section.sh_type != SHT_DYNSYM) continue;
      if (section.sh_link >= sections.size()) throw Unreadable{damaged};
      const Section& texts = sections[section.sh_link];
      const auto names = reader.table<char>(texts.sh_offset, texts.sh_size);
      for (const Symbol& symbol : reader.table<Symbol>(section.sh_offset, section.sh_size)) {
        if (!is_exported(symbol) || symbol.st_name >= names.size()) continue;
        const char* start = names.data() + symbol.st_name;
        const std::string name(start, strnlen(start, names.size() - symbol.st_name));
        result.exported.push_back(name);
        if (name == guard_symbol)
          result.guard = read_guard(reader, segments, symbol);
        else if (name.starts_with("binnacle_guard_v"))
          result.other_guard = name;
      }
    }
  } catch (const Unreadable& found) {
    result.unreadable = found.why;
  }
  return result;
}

}  // namespace binnacle::internal::plugin
