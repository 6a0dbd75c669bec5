// SPDX-License-Identifier: Apache-2.0
#include <new>

#include <sys/mman.h>

#include "netcdf_library.hpp"

namespace binnacle::results::nc {

void require_memory(std::size_t bytes) {
  void* const room = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) throw std::bad_alloc();
  ::munmap(room, bytes);
}

}  // namespace binnacle::results::nc
