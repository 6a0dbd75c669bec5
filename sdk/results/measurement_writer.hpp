// SPDX-License-Identifier: Apache-2.0
// MeasurementWriter: what became of the samples of one measurement, as a group of a file.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/step_log.hpp"
#include "columns.hpp"
#include "names.hpp"
#include "netcdf.hpp"
#include "results/writer_thread.hpp"

namespace binnacle::results {

class MeasurementWriter {
 public:
  /// level: of compression, 0 for none.
  MeasurementWriter(nc::Group group, const MeasurementInfo& info, int level, WriterThread& thread);

  // By the run's thread
  void add(const UpdateRecord& record);
  /// Hands over what is left, before close().
  void flush();

  // By the writer's
  void close();

 private:
  /// The first row of each sample, the second, …
  struct Slot {
    std::vector<double> residual, sigma, noise;
    std::vector<std::int64_t> key;
    void pad(std::size_t samples);
  };
  /// A chunk of samples on its way.
  struct Batch {
    std::vector<double> t, nis;
    std::vector<signed char> outcome;
    std::vector<std::int32_t> reason, rows;
    std::vector<std::vector<Slot>> slots;  // by row group
    std::size_t bytes() const;
  };
  /// Rows of one kind: variables (time, row), as wide as the widest sample.
  struct Rows {
    int residual = 0, sigma = 0, noise = 0, key = 0;
    bool are_there = false;
  };

  void add_rows(const UpdateRecord& record);
  std::int32_t number_of(const char* reason);

  void write(Batch& batch);
  void define(std::size_t samples);
  int add_variable(const std::string& name, nc_type type);
  void describe(int variable, const std::string& long_name, const std::string& unit);
  void add_outcome();
  void add_row_group(const RowGroupInfo& info, bool is_one_of_several);

  nc::Group group_;
  const MeasurementInfo& info_;
  int level_;
  WriterThread& thread_;
  Batch batch_;  // the open one
  std::map<std::string, std::int32_t, std::less<>> reasons_;

  bool is_defined_ = false;
  Names names_;
  std::size_t samples_of_chunk_ = 1;
  int time_dimension_ = 0;
  int time_ = 0, outcome_ = 0, reason_ = 0, nis_ = 0, rows_ = 0;
  std::vector<Rows> row_groups_;
  std::size_t first_ = 0;  // sample that comes next
};

}  // namespace binnacle::results
