// SPDX-License-Identifier: Apache-2.0
#include "netcdf.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

namespace binnacle::results::nc {

namespace {

int read_values(int group, int variable, const std::size_t* start, const std::size_t* count, double* values) {
  return nc_get_vara_double(group, variable, start, count, values);
}
int read_values(int group, int variable, const std::size_t* start, const std::size_t* count, signed char* values) {
  return nc_get_vara_schar(group, variable, start, count, values);
}
int read_values(int group, int variable, const std::size_t* start, const std::size_t* count, std::int32_t* values) {
  return nc_get_vara_int(group, variable, start, count, values);
}
int read_values(int group, int variable, const std::size_t* start, const std::size_t* count, std::int64_t* values) {
  static_assert(sizeof(std::int64_t) == sizeof(long long));
  return nc_get_vara_longlong(group, variable, start, count, reinterpret_cast<long long*>(values));
}

/// At the process's end HDF5 goes through all that it holds. A file whose last bytes found no room it writes once more
/// from freed memory (1.10.8 on Debian 12: SIGSEGV); what else it would free, the system does.
void keep_from_tidying() { H5dont_atexit(); }

/// Bytes of a variable for each of its file: deflate makes 1032 of one at most, and what was never written takes none.
constexpr std::uintmax_t most_inflated = 8192;

}  // namespace

void keep_quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

void check(int code) {
  if (code == NC_NOERR) return;
  const int reason = errno;
  constexpr int reasons[] = {ENOSPC, EDQUOT, EFBIG, EIO, EMFILE, ENFILE};
  const bool is_stated = std::ranges::find(reasons, reason) != std::end(reasons);
  // NetCDF says EACCES of all that HDF5 cannot create.
  if ((code == NC_EHDFERR || code == EACCES) && is_stated) throw Failure(std::strerror(reason));
  throw Failure(code > 0 ? std::strerror(code) : nc_strerror(code));
}

Group Group::add_group(const std::string& name) const {
  int id = -1;
  check(nc_def_grp(id_, name.c_str(), &id));
  return Group(id, most_bytes_);
}

int Group::add_dimension(const std::string& name, std::size_t size) const {
  int id = -1;
  check(nc_def_dim(id_, name.c_str(), size, &id));
  return id;
}

int Group::add_growing_dimension(const std::string& name) const { return add_dimension(name, NC_UNLIMITED); }

int Group::add_variable(const std::string& name, nc_type type, const std::vector<int>& dimensions,
                        const Storage& storage) const {
  int id = -1;
  check(nc_def_var(id_, name.c_str(), type, static_cast<int>(dimensions.size()), dimensions.data(), &id));
  if (storage.chunks.empty()) return id;
  check(nc_def_var_chunking(id_, id, NC_CHUNKED, storage.chunks.data()));
  if (storage.level != not_compressed) check(nc_def_var_deflate(id_, id, NC_SHUFFLE, 1, storage.level));
  std::size_t bytes = 0;
  check(nc_inq_type(id_, type, nullptr, &bytes));
  for (const std::size_t size : storage.chunks) bytes *= size;
  // Chunks are written whole and in order: more than two in memory would only take room, and what is not compressed goes
  // straight to the file where the cache is too small for it.
  check(nc_set_var_chunk_cache(id_, id, storage.level == not_compressed ? 1 : 2 * bytes, std::size_t{11}, 1.0f));
  return id;
}

void Group::put_text(int variable, const std::string& name, const std::string& text) const {
  check(nc_put_att_text(id_, variable, name.c_str(), text.size(), text.c_str()));
}

void Group::put_bytes(int variable, const std::string& name, const std::vector<signed char>& values) const {
  check(nc_put_att_schar(id_, variable, name.c_str(), NC_BYTE, values.size(), values.data()));
}

void Group::put_number(int variable, const std::string& name, double value) const {
  check(nc_put_att_double(id_, variable, name.c_str(), NC_DOUBLE, std::size_t{1}, &value));
}

void Group::put_integer(int variable, const std::string& name, std::int64_t value) const {
  const long long number = value;
  check(nc_put_att_longlong(id_, variable, name.c_str(), NC_INT64, std::size_t{1}, &number));
}

void Group::put_natural(int variable, const std::string& name, std::uint64_t value) const {
  const unsigned long long number = value;
  check(nc_put_att_ulonglong(id_, variable, name.c_str(), NC_UINT64, std::size_t{1}, &number));
}

void Group::fill_with_nan(int variable) const {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  check(nc_def_var_fill(id_, variable, NC_FILL, &nan));
}

int Group::add_texts(const std::string& name, const std::vector<int>& dimensions,
                     const std::vector<std::string>& texts) const {
  std::size_t length = 1;
  for (const auto& text : texts) length = std::max(length, text.size());
  std::string characters;
  for (const auto& text : texts) characters.append(text).append(length - text.size(), '\0');
  const std::string dimension_name = "text_" + std::to_string(length);
  int last = -1;
  if (nc_inq_dimid(id_, dimension_name.c_str(), &last) != NC_NOERR) last = add_dimension(dimension_name, length);
  auto all = dimensions;
  all.push_back(last);
  std::vector<std::size_t> shape;
  for (const int dimension : all) {
    shape.push_back(0);
    check(nc_inq_dimlen(id_, dimension, &shape.back()));
  }
  const int id = add_variable(name, NC_CHAR, all, {shape});
  put_text(id, "_Encoding", "utf-8");
  check(nc_put_var_text(id_, id, characters.data()));
  return id;
}

void Group::write(int variable, const std::size_t* start, const std::size_t* count, const double* values) const {
  check(nc_put_vara_double(id_, variable, start, count, values));
}

void Group::write(int variable, const std::size_t* start, const std::size_t* count, const signed char* values) const {
  check(nc_put_vara_schar(id_, variable, start, count, values));
}

void Group::write(int variable, const std::size_t* start, const std::size_t* count, const std::int32_t* values) const {
  check(nc_put_vara_int(id_, variable, start, count, values));
}

void Group::write(int variable, const std::size_t* start, const std::size_t* count, const std::int64_t* values) const {
  check(nc_put_vara_longlong(id_, variable, start, count, reinterpret_cast<const long long*>(values)));
}

std::vector<Group> Group::groups() const {
  int count = 0;
  check(nc_inq_grps(id_, &count, nullptr));
  std::vector<int> ids(static_cast<std::size_t>(count));
  check(nc_inq_grps(id_, nullptr, ids.data()));
  std::vector<Group> groups;
  for (const int id : ids) groups.emplace_back(id, most_bytes_);
  return groups;
}

std::optional<Group> Group::group(const std::string& name) const {
  int id = -1;
  const int code = nc_inq_ncid(id_, name.c_str(), &id);
  if (code == NC_ENOGRP) return std::nullopt;
  check(code);
  return Group(id, most_bytes_);
}

std::string Group::name() const {
  char name[NC_MAX_NAME + 1];
  check(nc_inq_grpname(id_, name));
  return name;
}

int Group::variables() const {
  int count = 0;
  check(nc_inq_nvars(id_, &count));
  return count;
}

std::optional<int> Group::variable(const std::string& name) const {
  int id = -1;
  const int code = nc_inq_varid(id_, name.c_str(), &id);
  if (code == NC_ENOTVAR) return std::nullopt;
  check(code);
  return id;
}

std::string Group::variable_name(int variable) const {
  char name[NC_MAX_NAME + 1];
  check(nc_inq_varname(id_, variable, name));
  return name;
}

std::vector<int> Group::dimensions(int variable) const {
  int count = 0;
  check(nc_inq_varndims(id_, variable, &count));
  std::vector<int> ids(static_cast<std::size_t>(count));
  check(nc_inq_vardimid(id_, variable, ids.data()));
  return ids;
}

std::vector<std::size_t> Group::shape(int variable) const {
  std::vector<std::size_t> sizes;
  for (const int dimension : dimensions(variable)) {
    sizes.push_back(0);
    check(nc_inq_dimlen(id_, dimension, &sizes.back()));
  }
  return sizes;
}

std::string Group::dimension_name(int dimension) const {
  char name[NC_MAX_NAME + 1];
  check(nc_inq_dimname(id_, dimension, name));
  return name;
}

bool Group::has(int variable, const std::string& attribute) const {
  int number = 0;
  const int code = nc_inq_attid(id_, variable, attribute.c_str(), &number);
  if (code == NC_ENOTATT) return false;
  check(code);
  return true;
}

std::string Group::text(int variable, const std::string& attribute) const {
  if (!has(variable, attribute)) return {};
  nc_type type = NC_NAT;
  std::size_t length = 0;
  check(nc_inq_att(id_, variable, attribute.c_str(), &type, &length));
  if (type != NC_CHAR) throw Failure("its attribute '" + attribute + "' is not a text");
  std::string text(length, '\0');
  check(nc_get_att_text(id_, variable, attribute.c_str(), text.data()));
  return text;
}

std::vector<signed char> Group::bytes(int variable, const std::string& attribute) const {
  if (!has(variable, attribute)) return {};
  std::size_t length = 0;
  check(nc_inq_attlen(id_, variable, attribute.c_str(), &length));
  std::vector<signed char> values(length);
  check(nc_get_att_schar(id_, variable, attribute.c_str(), values.data()));
  return values;
}

std::uint64_t Group::natural(int variable, const std::string& attribute) const {
  std::size_t length = 0;
  check(nc_inq_attlen(id_, variable, attribute.c_str(), &length));
  if (length != 1) throw Failure("its attribute '" + attribute + "' is not a number");
  unsigned long long value = 0;
  check(nc_get_att_ulonglong(id_, variable, attribute.c_str(), &value));
  return value;
}

std::size_t Group::count_of(int variable, const std::vector<std::size_t>& sizes) const {
  nc_type type = NC_NAT;
  std::size_t bytes = 1;
  check(nc_inq_vartype(id_, variable, &type));
  check(nc_inq_type(id_, type, nullptr, &bytes));
  const std::uintmax_t most = most_bytes_ / std::max<std::size_t>(bytes, 1);
  std::size_t count = 1;
  for (const std::size_t size : sizes) {
    if (size > most / std::max<std::size_t>(count, 1))
      throw Failure("its variable '" + variable_name(variable) +
                    "' declares more values than a file of its size holds");
    count *= size;
  }
  return count;
}

std::vector<std::string> Group::read_texts(int variable) const {
  nc_type type = NC_NAT;
  check(nc_inq_vartype(id_, variable, &type));
  const auto sizes = shape(variable);
  if (type != NC_CHAR || sizes.empty()) throw Failure("its variable '" + variable_name(variable) + "' holds no texts");
  const std::size_t count = count_of(variable, sizes);
  std::string characters(count, '\0');
  if (count > 0) check(nc_get_var_text(id_, variable, characters.data()));
  std::vector<std::string> texts;
  for (std::size_t at = 0; at < count; at += sizes.back()) {
    std::string text = characters.substr(at, sizes.back());
    text.erase(text.find_last_not_of('\0') + 1);
    texts.push_back(std::move(text));
  }
  return texts;
}

template <class T>
std::vector<T> Group::read(int variable) const {
  const auto sizes = shape(variable);
  const std::size_t count = count_of(variable, sizes);
  std::vector<T> values(count);
  const std::vector<std::size_t> start(sizes.size() + 1, 0);
  if (count > 0) check(read_values(id_, variable, start.data(), sizes.data(), values.data()));
  return values;
}

template <class T>
std::vector<T> Group::read_column(int variable, std::size_t column) const {
  const auto sizes = shape(variable);
  if (sizes.size() != 2 || column >= sizes[1])
    throw Failure("its variable '" + variable_name(variable) + "' lacks a column");
  count_of(variable, sizes);
  std::vector<T> values(sizes[0]);
  const std::size_t start[] = {0, column}, count[] = {sizes[0], 1};
  if (!values.empty()) check(read_values(id_, variable, start, count, values.data()));
  return values;
}

template std::vector<double> Group::read(int) const;
template std::vector<signed char> Group::read(int) const;
template std::vector<std::int32_t> Group::read(int) const;
template std::vector<std::int64_t> Group::read(int) const;
template std::vector<double> Group::read_column(int, std::size_t) const;
template std::vector<std::int64_t> Group::read_column(int, std::size_t) const;

File File::create(const std::filesystem::path& path) {
  require_memory(memory_of_file);
  keep_from_tidying();
  int id = -1;
  errno = 0;
  check(nc_create(std::filesystem::absolute(path).c_str(), NC_NETCDF4 | NC_CLOBBER, &id));
  return File(id, std::numeric_limits<std::uintmax_t>::max());
}

File File::open(const std::filesystem::path& path) {
  require_memory(memory_of_file);
  keep_from_tidying();
  int id = -1;
  errno = 0;
  check(nc_open(std::filesystem::absolute(path).c_str(), NC_NOWRITE, &id));
  return File(id, most_inflated * std::filesystem::file_size(path));
}

File::~File() {
  if (id_ >= 0) nc_close(id_);
}

void File::close() {
  errno = 0;
  check(nc_close(std::exchange(id_, -1)));
}

}  // namespace binnacle::results::nc
