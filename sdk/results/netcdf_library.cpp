// SPDX-License-Identifier: Apache-2.0
#include "netcdf_library.hpp"

#include <string>

#include <dlfcn.h>

#include "results/results.hpp"

namespace binnacle::results {

namespace nc {

namespace {

constexpr const char* library_file = BINNACLE_NETCDF_FILE;  // "libnetcdf.so.19"

[[noreturn]] void refuse(const std::string& why) {
  throw LibraryMissing("the NetCDF library cannot be loaded: " + why + "; install the Debian package " +
                       BINNACLE_NETCDF_PACKAGE);
}

/// The symbol in the library, or in one that it was linked with.
template <class Function>
void find(void* handle, const char* name, Function& function) {
  void* const symbol = dlsym(handle, name);
  if (!symbol) refuse(std::string("'") + library_file + "' has no function " + name);
  function = reinterpret_cast<Function>(symbol);
}

Library load() {
  // All of it now: a function that is missing below must not end the program in the middle of a run. Local: a program
  // that embeds this may have another HDF5.
  require_memory(memory_of_library);
  void* const handle = dlopen(library_file, RTLD_NOW | RTLD_LOCAL);
  if (!handle) refuse(dlerror());
  Library library{};
#define BINNACLE_NETCDF_FIND(name) find(handle, #name, library.name);
  BINNACLE_NETCDF_CALLS(BINNACLE_NETCDF_FIND)
#undef BINNACLE_NETCDF_FIND
  return library;
}

}  // namespace

const Library& library() {
  static const Library loaded = load();
  return loaded;
}

}  // namespace nc

void load_netcdf() {
  try {
    nc::library();
  } catch (const nc::LibraryMissing& missing) {
    throw WriteError(missing.what());
  }
}

}  // namespace binnacle::results
