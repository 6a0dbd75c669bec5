// SPDX-License-Identifier: Apache-2.0
// What a loaded library was built as.
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>

#include <elf.h>
#include <link.h>

#include "base/hash.hpp"
#include "plugin/library.hpp"

namespace binnacle::internal::plugin {

namespace {

struct Search {
  std::uintptr_t address;
  std::string found;
};

/// The build ID among the notes of a segment.
std::string build_id(const char* at, std::size_t left) {
  constexpr std::string_view gnu("GNU\0", 4);
  const auto padded = [](std::size_t size) { return (size + 3) / 4 * 4; };
  ElfW(Nhdr) head;
  while (left >= sizeof head) {
    std::memcpy(&head, at, sizeof head);
    const std::size_t name = padded(head.n_namesz), text = padded(head.n_descsz);
    if (name + text > left - sizeof head) break;
    if (head.n_type == NT_GNU_BUILD_ID && std::string_view(at + sizeof head, head.n_namesz) == gnu)
      return std::string(at + sizeof head + name, head.n_descsz);
    at += sizeof head + name + text;
    left -= sizeof head + name + text;
  }
  return "";
}

int look_at(dl_phdr_info* info, std::size_t, void* data) {
  auto& search = *static_cast<Search*>(data);
  bool is_it = false;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const auto& segment = info->dlpi_phdr[i];
    const std::uintptr_t begin = info->dlpi_addr + segment.p_vaddr;
    is_it = is_it || (segment.p_type == PT_LOAD && search.address >= begin && search.address - begin < segment.p_memsz);
  }
  if (!is_it) return 0;
  for (int i = 0; i < info->dlpi_phnum && search.found.empty(); ++i)
    if (const auto& segment = info->dlpi_phdr[i]; segment.p_type == PT_NOTE)
      search.found = build_id(reinterpret_cast<const char*>(info->dlpi_addr + segment.p_vaddr), segment.p_memsz);
  return 1;
}

std::string checksum_of(const std::filesystem::path& path) {
  base::Fnv1a hash;
  std::ifstream file(path, std::ios::binary);
  std::array<char, 1 << 14> block;
  while (file.read(block.data(), block.size()) || file.gcount() > 0)
    hash.add(std::string_view(block.data(), static_cast<std::size_t>(file.gcount())));
  return std::to_string(hash.value());
}

}  // namespace

std::string build_of(const void* address, const std::filesystem::path& file) {
  Search search{reinterpret_cast<std::uintptr_t>(address), {}};
  dl_iterate_phdr(look_at, &search);
  return search.found.empty() ? checksum_of(file) : search.found;
}

}  // namespace binnacle::internal::plugin
