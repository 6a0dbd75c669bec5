// SPDX-License-Identifier: Apache-2.0
// run.nc as the report and others read it: edits of a good one.
#include "results/results.hpp"

#include <zlib.h>

#include "../edits.hpp"
#include "../reader.hpp"

namespace binnacle::fuzz {

namespace {

std::string unpacked(const char* path) {
  std::string all, block(1 << 16, '\0');
  const gzFile file = gzopen(path, "rb");
  if (!file) throw std::logic_error(std::string("cannot read ") + path);
  for (int got = 1; got > 0; all.append(block, 0, static_cast<std::size_t>(std::max(got, 0))))
    got = gzread(file, block.data(), static_cast<unsigned>(block.size()));
  gzclose(file);
  return all;
}

}  // namespace

void try_bytes(std::string_view bytes) {
  static const test::Folder folder;
  static const std::string good = unpacked(BINNACLE_FUZZ_TEMPLATES "/run.nc.gz");
  folder.write("run.nc", edited(good, bytes));
  try {
    results::read(folder.file(""));
  } catch (const std::runtime_error&) {
  }
}

}  // namespace binnacle::fuzz
