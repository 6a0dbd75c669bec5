// SPDX-License-Identifier: Apache-2.0
// The csv source: recorded samples from delimited text, plain or gzipped.
#pragma once

#include <cstdint>
#include <memory>

#include "binnacle/source.hpp"
#include "csv_table.hpp"

namespace binnacle::csv {

/// One channel, of the source's own name, with one field per entry of `columns`. Memory: the index of the next row.
class CsvSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit CsvSource(const Binding& binding, const Limits& limits = {});

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& bytes, SourceOutput& output) const override;

 private:
  Limits limits_;
  Layout layout_;
  OutputChannel channel_;
  Memory<std::uint64_t> next_;  // row
  std::unique_ptr<Table> table_;
};

}  // namespace binnacle::csv
