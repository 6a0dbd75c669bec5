// SPDX-License-Identifier: Apache-2.0
// ErrorWriter: a filter's errors against references and withheld samples, as a group of a file.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "names.hpp"
#include "netcdf.hpp"
#include "score/run.hpp"

namespace binnacle::results {

class ErrorWriter {
 public:
  /// level: of compression, 0 for none.
  ErrorWriter(nc::Group group, const FilterInfo& info, int level) : group_(group), info_(info), level_(level) {}
  void add(const score::ErrorSeries& errors);

 private:
  struct TimeBase {
    int dimension = 0;
    std::vector<Time> t;
    std::string name;
  };
  /// The error components of a block, as one variable.
  struct BlockErrors {
    int values = -1, sigmas = -1;
    std::size_t base = 0;
  };

  std::size_t time_base(const score::ErrorSeries& errors);
  int add_variable(const std::string& name, const std::vector<int>& dimensions, const score::ErrorSeries& errors,
                   const std::string& long_name);
  void write_scalar(const score::ErrorSeries& errors, std::size_t base);
  void write_component(const score::ErrorSeries& errors, const BlockInfo& block, int component, std::size_t base);
  BlockErrors add_block_errors(const score::ErrorSeries& errors, const BlockInfo& block, std::size_t base);
  void write_values(int variable, int column, std::span<const double> values);

  nc::Group group_;
  const FilterInfo& info_;
  int level_;
  Names names_;
  std::vector<TimeBase> bases_;
  std::map<const BlockInfo*, BlockErrors> block_errors_;
};

}  // namespace binnacle::results
