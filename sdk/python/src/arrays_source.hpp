// SPDX-License-Identifier: Apache-2.0
// The source numpy/arrays: samples that Python gave as arrays.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "binnacle/source.hpp"

namespace binnacle::python {

/// One channel, of the source's own name. What it declares is what a csv file with such columns declares.
class ArraysSource final : public Source {
 public:
  static ComponentSpec spec();
  explicit ArraysSource(const Binding& binding);

  void open(Reporter& reporter) override;
  SourceStatus next(const MemoryView& memory, SourceOutput& out) const override;

 private:
  struct Column {
    std::string name;
    std::size_t index = 0;  // in a line of the data
    FieldKind kind = FieldKind::level;
    double scale = 1;             // to SI
    std::vector<double> missing;  // numbers that stand for "no data"
    bool may_be_nan = false;
  };

  void read_columns(const Parameters& parameters, ChannelDeclaration& channel);
  void read_rows(const Parameters& parameters, ChannelDeclaration& channel);
  void read_intervals(const Parameters& parameters, ChannelDeclaration& channel);
  void check_times() const;
  void check_values() const;
  void check_keys(std::size_t begin, std::size_t end) const;
  [[noreturn]] void refuse(const std::string& code, const std::string& message) const;
  double value(std::size_t line, const Column& column) const;

  std::string file_;  // what messages call it: data['imu']
  std::shared_ptr<const ArrayData> data_;
  std::vector<Column> columns_;
  std::optional<std::size_t> key_;   // of rows, in columns_
  std::vector<Time> times_;          // of samples, where lines are rows
  std::vector<std::size_t> begins_;  // their first lines
  bool has_intervals_ = false;
  std::optional<Time> interval_, max_gap_;
  std::vector<Time> starts_;  // empty: instants
  OutputChannel channel_;
  Memory<std::uint64_t> next_;
};

}  // namespace binnacle::python
