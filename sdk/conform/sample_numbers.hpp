// SPDX-License-Identifier: Apache-2.0
// The numbers of a sample, made up or given by a component's surroundings.
#pragma once

#include <random>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/sample.hpp"
#include "binnacle/spec.hpp"

namespace binnacle::conform {

using Json = nlohmann::ordered_json;

/// The numbers of one sample, in the order of a component's fields.
struct SampleNumbers {
  std::vector<double> epoch;       // per-epoch fields
  std::vector<double> row;         // rows × per-row fields, row-major
  std::vector<double> covariance;  // column-major, where the channel attaches one
  int rows = 0;
  Time t = 2'000'000'000;
  bool is_available = true;  // false: an auxiliary channel that is not connected

  SampleView view() const;
  std::size_t count() const { return epoch.size() + row.size(); }
  double& at(std::size_t i) { return i < epoch.size() ? epoch[i] : row[i - epoch.size()]; }
  double at(std::size_t i) const { return i < epoch.size() ? epoch[i] : row[i - epoch.size()]; }
};

/// What ComponentSpec::surroundings specify of samples: "sample": {field: SI number}, "inputs": {input: {field: SI number}},
/// "time": SI number. A field per row takes a list with a number per row, or one number for all of them.
class Surroundings {
 public:
  /// Of text that wrong_shape() finds nothing wrong with.
  explicit Surroundings(const ComponentSpec& spec);
  const Json& sample() const { return sample_; }
  Json input(const std::string& name) const { return inputs_.value(name, Json::object()); }
  Time time() const { return time_; }

 private:
  Json sample_ = Json::object(), inputs_ = Json::object();
  Time time_ = 2'000'000'000;
};

/// What is wrong with a component's surroundings, for people; "" when nothing. The example's fault, not the code's.
std::string wrong_shape(const ComponentSpec& spec);

/// A plausible size of an error with this unit.
double scale_of(const std::string& unit);

/// Plausible numbers for the fields, those given in their place. has[i]: whether the channel carries the i-th field; what
/// it does not carry is NaN, as the kernel hands it out. Rows differ from each
/// other. spread: of the made-up numbers, in plausible sizes of their units.
SampleNumbers made_up(const std::vector<FieldSpec>& fields, const std::vector<bool>& has, const Json& given, Time t,
                      std::mt19937_64& random, double spread = 0.1);
/// Rows by which a model may find others: plain numbers per row that nobody gave become 1, 2, 3, …
void number_rows(SampleNumbers& numbers, const std::vector<FieldSpec>& fields, const Json& given);

}  // namespace binnacle::conform
