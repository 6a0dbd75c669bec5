// SPDX-License-Identifier: Apache-2.0
// The NetCDF library, loaded by the first call: it brings HDF5, curl, Kerberos and some fifty more libraries, which cost a
// start several times what a command without results takes.
//
// In namespace binnacle::results::nc every function of BINNACLE_NETCDF_CALLS is called by its own name, as if it were
// linked. What is called and not listed does not link: add its name to the list.
#pragma once

#include <stdexcept>

#include <H5Epublic.h>
#include <H5public.h>
#include <netcdf.h>

// HDF5's own functions too: they are looked up in what NetCDF was linked with.
// clang-format off
#define BINNACLE_NETCDF_CALLS(X)                                                                                         \
  X(H5dont_atexit) X(H5Eset_auto2)                                                                                       \
  X(nc_close) X(nc_create) X(nc_open) X(nc_strerror)                                                                     \
  X(nc_def_dim) X(nc_def_grp) X(nc_def_var) X(nc_def_var_chunking) X(nc_def_var_deflate) X(nc_def_var_fill)              \
  X(nc_get_att_schar) X(nc_get_att_text) X(nc_get_att_ulonglong) X(nc_get_var_text) X(nc_get_vara_double)                \
  X(nc_get_vara_int) X(nc_get_vara_longlong) X(nc_get_vara_schar)                                                        \
  X(nc_inq_att) X(nc_inq_attid) X(nc_inq_attlen) X(nc_inq_dimid) X(nc_inq_dimlen) X(nc_inq_dimname) X(nc_inq_grpname)    \
  X(nc_inq_grps) X(nc_inq_ncid) X(nc_inq_nvars) X(nc_inq_type) X(nc_inq_vardimid) X(nc_inq_varid) X(nc_inq_varname)      \
  X(nc_inq_varndims) X(nc_inq_vartype)                                                                                   \
  X(nc_put_att_double) X(nc_put_att_longlong) X(nc_put_att_schar) X(nc_put_att_text) X(nc_put_att_ulonglong)             \
  X(nc_put_var_text) X(nc_put_vara_double) X(nc_put_vara_int) X(nc_put_vara_longlong) X(nc_put_vara_schar)               \
  X(nc_set_var_chunk_cache)
// clang-format on

namespace binnacle::results::nc {

/// What NetCDF, or the system under it, says is wrong; one line without the file's name.
class Failure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The library cannot be loaded; why, and the Debian package that has it.
class LibraryMissing : public Failure {
 public:
  using Failure::Failure;
};

/// Pointers to the functions.
struct Library {
#define BINNACLE_NETCDF_POINTER(name) decltype(&::name) name;
  BINNACLE_NETCDF_CALLS(BINNACLE_NETCDF_POINTER)
#undef BINNACLE_NETCDF_POINTER
};

/// Throws std::bad_alloc where there is no room for so much: NetCDF and HDF5 use memory without asking whether they got it
/// (4.9.0 and 1.10.8 on Debian 12: SIGSEGV).
void require_memory(std::size_t bytes);
inline constexpr std::size_t memory_of_library = 96u << 20, memory_of_file = 32u << 20, memory_of_rows = 16u << 20;

/// Loads it if that is not done; it stays until the process ends. From any thread. Throws LibraryMissing.
const Library& library();

/// Calls the function that one of the pointers points to.
template <auto pointer>
struct Call {
  template <class... Arguments>
  auto operator()(Arguments... arguments) const {
    return (library().*pointer)(arguments...);
  }
};

#define BINNACLE_NETCDF_CALL(name) inline constexpr Call<&Library::name> name{};
BINNACLE_NETCDF_CALLS(BINNACLE_NETCDF_CALL)
#undef BINNACLE_NETCDF_CALL

}  // namespace binnacle::results::nc
