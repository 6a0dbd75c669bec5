// SPDX-License-Identifier: Apache-2.0
// What a model in Python is handed when it is bound, and where it declares what it will do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/measurement_model.hpp"
#include "binnacle/noise_estimator.hpp"
#include "binnacle/process_model.hpp"
#include "binnacle/source.hpp"
#include "models.hpp"

namespace binnacle::python {

/// What a model remembers, by name: words of 8 bytes in the kernel's arena, a copy of them in Python during a call.
class MemoryLayout {
 public:
  /// {"count": 0, "mean": np.zeros(3)}: int, float, or an array of either, with its first value. Throws TypeError, ValueError.
  void add(const py::dict& items);
  std::size_t words() const { return initial_.size(); }
  void write_initial(std::byte* memory) const;
  py::dict read(const std::byte* memory) const;
  /// Throws KeyError, TypeError or ValueError where an item is missing, or no longer what was declared.
  void write(const py::dict& items, std::byte* memory) const;

 private:
  struct Item {
    std::string name;
    bool is_integer = false, is_scalar = false;
    std::vector<py::ssize_t> shape;
    std::size_t first = 0, count = 1;
  };
  static Item described(const std::string& name, const py::handle& value);
  static void store(const Item& item, const py::handle& value, std::uint64_t* words);

  std::vector<Item> items_;
  std::vector<std::uint64_t> initial_;
};

/// `binding` of a model's __init__. All but what it declares is of the Binding, and ends with the constructor.
class ModelBinding {
 public:
  ModelBinding(const Binding& binding, const ModelClass& model, const NoiseBinding* noise);

  const Binding& binding() const;
  const ModelClass& model() const { return *model_; }
  /// Nothing can be asked or declared any more.
  void close() { binding_ = nullptr; }

  py::dict parameters() const;
  py::dict ports() const;
  Port port(const std::string& name) const { return binding().port(name); }
  bool is_bound(const std::string& field) const;
  std::vector<std::pair<std::string, std::string>> covariance(const std::optional<std::string>& input) const;

  // Declared. Names are checked when they are.
  int rows = 0;
  struct Group {
    std::string name;
    std::optional<std::string> port;
    int rows = 0;
    std::string unit;
  };
  std::vector<Group> groups;
  std::optional<std::vector<std::string>> reads;
  bool wants_covariance = false, is_judged_by_nominal = false;
  std::optional<std::vector<std::pair<std::string, std::string>>> couples, adds_noise;
  std::map<std::string, double> steps;
  std::vector<double> constants;
  MemoryLayout memory;
  std::optional<PortBinding> yields;
  std::vector<ChannelDeclaration> channels;
  int max_rows = 0;  // a noise estimator's
  std::vector<std::pair<std::string, std::string>> noise_groups;

 private:
  const Binding* binding_;
  const ModelClass* model_;
};

void bind_model_bindings(py::module_& module);

}  // namespace binnacle::python
