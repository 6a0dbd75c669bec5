// SPDX-License-Identifier: Apache-2.0
// The csv source: recorded samples from delimited text, plain or gzipped.
#pragma once

#include <vector>

#include "binnacle/source.hpp"
#include "csv_table.hpp"

namespace binnacle::csv {

/// One channel, of the source's own name, with one field per entry of `columns`. Memory: the index of the next row.
class CsvSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit CsvSource(const Binding& binding);

  const std::vector<ChannelDeclaration>& channels() const noexcept override { return channels_; }
  void open(Reporter& reporter) override;
  std::size_t memory_bytes() const noexcept override;
  void start(std::uint64_t seed, std::byte* memory) const override;
  SourceStatus next(std::byte* memory, SampleSlot* slots, int& channel) const override;

 private:
  Layout layout_;
  std::vector<ChannelDeclaration> channels_;
  Table table_;
};

}  // namespace binnacle::csv
