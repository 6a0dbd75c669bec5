// SPDX-License-Identifier: Apache-2.0
// The NetCDF library as objects: every return code is looked at, a file that goes out of scope is closed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "netcdf_library.hpp"

namespace binnacle::results::nc {

/// Throws Failure unless the code says that all went well. The system's own reason, where it left one, says more than
/// "HDF error".
void check(int code);

/// HDF5 prints its failures to stderr, unless each thread that calls it says otherwise; for a thread that opens no file itself.
void keep_quiet();

/// How much of a variable's bytes deflate saves: 0 leaves them as they are, in chunks that go to the file as they come.
inline constexpr int not_compressed = 0, lightly_compressed = 1;

/// In chunks of this shape, whole ones written at once; no chunks: contiguous.
struct Storage {
  std::vector<std::size_t> chunks = {};
  int level = lightly_compressed;
};

/// In groups and variables of a file; as long as it is open.
class Group {
 public:
  /// Of a file that is read: bytes that one of its variables may have.
  explicit Group(int id, std::uintmax_t most_bytes) : id_(id), most_bytes_(most_bytes) {}

  // Writing
  Group add_group(const std::string& name) const;
  int add_dimension(const std::string& name, std::size_t size) const;
  int add_growing_dimension(const std::string& name) const;
  int add_variable(const std::string& name, nc_type type, const std::vector<int>& dimensions,
                   const Storage& storage = {}) const;
  void put_text(int variable, const std::string& name, const std::string& text) const;
  void put_bytes(int variable, const std::string& name, const std::vector<signed char>& values) const;
  void put_number(int variable, const std::string& name, double value) const;
  void put_integer(int variable, const std::string& name, std::int64_t value) const;
  void put_natural(int variable, const std::string& name, std::uint64_t value) const;
  void fill_with_nan(int variable) const;
  /// A variable of texts, whole: characters with a last dimension of their own, "text_LENGTH". Strings of variable length
  /// would read nicer in a dump, but older MATLAB does not know them, and HDF5 trusts a damaged file's blindly.
  int add_texts(const std::string& name, const std::vector<int>& dimensions,
                const std::vector<std::string>& texts) const;
  void write(int variable, const std::size_t* start, const std::size_t* count, const double* values) const;
  void write(int variable, const std::size_t* start, const std::size_t* count, const signed char* values) const;
  void write(int variable, const std::size_t* start, const std::size_t* count, const std::int32_t* values) const;
  void write(int variable, const std::size_t* start, const std::size_t* count, const std::int64_t* values) const;

  // Reading
  std::vector<Group> groups() const;
  std::optional<Group> group(const std::string& name) const;
  std::string name() const;
  int variables() const;
  std::optional<int> variable(const std::string& name) const;
  std::string variable_name(int variable) const;
  std::vector<std::size_t> shape(int variable) const;
  std::vector<int> dimensions(int variable) const;
  std::string dimension_name(int dimension) const;
  bool has(int variable, const std::string& attribute) const;
  /// "" where there is none.
  std::string text(int variable, const std::string& attribute) const;
  std::vector<signed char> bytes(int variable, const std::string& attribute) const;
  std::uint64_t natural(int variable, const std::string& attribute) const;
  /// As add_texts() had them.
  std::vector<std::string> read_texts(int variable) const;
  template <class T>
  std::vector<T> read(int variable) const;
  /// One column of a variable (rows, columns).
  template <class T>
  std::vector<T> read_column(int variable, std::size_t column) const;

  int id() const { return id_; }

 private:
  /// Values of a variable, which memory is taken for: a shape is not believed that the file has no room for.
  std::size_t count_of(int variable, const std::vector<std::size_t>& sizes) const;

  int id_;
  std::uintmax_t most_bytes_;
};

class File {
 public:
  static File create(const std::filesystem::path& path);
  static File open(const std::filesystem::path& path);
  ~File();
  File(File&& other) noexcept : id_(std::exchange(other.id_, -1)), most_bytes_(other.most_bytes_) {}
  File& operator=(File&&) = delete;

  Group root() const { return Group(id_, most_bytes_); }
  /// What was written may only now turn out not to fit.
  void close();

 private:
  File(int id, std::uintmax_t most_bytes) : id_(id), most_bytes_(most_bytes) {}
  int id_ = -1;
  std::uintmax_t most_bytes_;
};

}  // namespace binnacle::results::nc
