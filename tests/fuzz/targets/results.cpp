// SPDX-License-Identifier: Apache-2.0
// run.nc and study.nc as the report and others read them, of a file that says anything.
#include "results/results.hpp"

#include "../given_netcdf.hpp"
#include "../reader.hpp"

namespace binnacle::fuzz {

namespace {

/// A stand-in of the file: what it may declare goes by its size.
constexpr std::size_t size_of_file = 256;

struct Folders {
  test::Folder run, study;
  Folders() {
    run.write("run.nc", std::string(size_of_file, ' '));
    run.write("summary.json", "{}");
    study.write("study.nc", std::string(size_of_file, ' '));
    study.write("study.json", "{}");
  }
};

}  // namespace

void try_bytes(std::string_view bytes) {
  static const Folders folders;
  if (!give_netcdf(bytes)) return;
  for (const test::Folder* folder : {&folders.run, &folders.study}) try {
      results::read(folder->file(""));
    } catch (const std::runtime_error&) {
    }
}

}  // namespace binnacle::fuzz
