// SPDX-License-Identifier: Apache-2.0
// MeasurementWriter: what became of the samples of one measurement, as a group of a file.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/step_log.hpp"
#include "columns.hpp"
#include "names.hpp"
#include "netcdf.hpp"

namespace binnacle::results {

class MeasurementWriter {
 public:
  MeasurementWriter(nc::Group group, const MeasurementInfo& info);
  void add(const UpdateRecord& record);
  void close();

 private:
  /// Rows of one kind: variables (time, row), as wide as the widest sample.
  struct Rows {
    int row_dimension = 0;
    int residual = 0, sigma = 0, noise = 0, key = 0;
    struct Slot {
      Column<double> residual, sigma, noise;
      Column<std::int64_t> key;
    };
    std::deque<Slot> slots;
  };

  int id_of(const char* name) const { return *group_.variable(name); }
  void describe(int variable, const std::string& long_name, const std::string& unit);
  void add_outcome();
  void add_row_group(const RowGroupInfo& info, bool is_one_of_several);
  void add_rows(const UpdateRecord& record);
  Rows::Slot& slot_of(Rows& rows, std::size_t index);
  std::int32_t number_of(const char* reason);
  void write();

  nc::Group group_;
  Names names_;
  int time_dimension_ = 0;
  std::optional<Column<double>> time_, nis_;
  std::optional<Column<signed char>> outcome_;
  std::optional<Column<std::int32_t>> reason_, rows_;
  std::vector<Rows> row_groups_;
  std::map<std::string, std::int32_t, std::less<>> reasons_;
  std::size_t first_ = 0;  // sample of the open chunk
};

}  // namespace binnacle::results
