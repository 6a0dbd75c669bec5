// SPDX-License-Identifier: Apache-2.0
// The samples of a file, in memory as far as they have room there, and else read again by blocks.
#pragma once

#include <cstdint>
#include <memory>

#include "binnacle/source.hpp"
#include "layout.hpp"

namespace binnacle::csv {

class Table {
 public:
  /// Reads and checks all of the file. Throws ComponentError::in_data at the first fault that is not to be skipped.
  Table(const Layout& layout, const Limits& limits, Reporter& reporter);
  ~Table();

  std::uint64_t size() const;
  /// Sample i, for several threads. Throws ComponentError::in_data where the file is no longer what it was.
  void write(std::uint64_t i, SampleWriter& out) const;

 private:
  class Parts;

  std::unique_ptr<Parts> parts_;
};

}  // namespace binnacle::csv
