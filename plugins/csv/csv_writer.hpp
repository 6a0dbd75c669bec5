// SPDX-License-Identifier: Apache-2.0
// The csv_writer sink: samples of a channel as delimited text, as the csv source reads it.
#pragma once

#include <string>
#include <vector>

#include "binnacle/source.hpp"

namespace binnacle::csv {

/// One row per sample. Written beside its final place and moved there by close(): a run that breaks leaves no file.
class CsvWriter final : public Sink {
 public:
  static ComponentSpec spec();
  explicit CsvWriter(const Binding& binding);

  void open() override;
  void on(Input from, const SampleView& sample) override;
  void close() override;
  bool exchange(StateBytes& bytes) override;

 private:
  struct Column {
    std::string field;
    std::string name;
    Field handle;
    double unit;  // in SI
    bool has_number = false;
  };

  void write();

  std::string path_;
  std::vector<Column> columns_;
  Time offset_ = 0;
  std::string header_;
  std::string text_;
};

}  // namespace binnacle::csv
