// SPDX-License-Identifier: Apache-2.0
// stream/csv: one row a line.
#pragma once

#include "line_source.hpp"

namespace binnacle::stream {

class CsvSource final : public LineSource {
 public:
  static ComponentSpec spec();
  explicit CsvSource(const Binding& binding);

 private:
  bool parse(std::string_view line, LineSample& sample) const override;
  void begin_anew() const override { columns_->is_known = !has_header_; }
  void split(std::string_view line) const;
  void read_header() const;
  std::size_t column_of(const std::string& name) const;

  /// Of the connection, once its header is known.
  struct Columns {
    bool is_known = false;
    std::size_t time = 0;
    std::vector<std::size_t> fields;
    std::vector<std::string> cells;  // of the line at work
  };
  char delimiter_ = ',';
  std::string comment_;
  bool has_header_ = true;
  std::shared_ptr<Columns> columns_ = std::make_shared<Columns>();
};

}  // namespace binnacle::stream
