// SPDX-License-Identifier: Apache-2.0
// A vector of like quantities as a state block.
#include "vector_block.hpp"

#include <algorithm>
#include <numeric>

namespace binnacle::core {

namespace {

constexpr int largest_size = 64;
const char* const norm_name = "norm";

std::vector<std::string> default_names(int size) {
  if (size == 1) return {"x"};
  if (size == 3) return {"x", "y", "z"};
  std::vector<std::string> names;
  for (int i = 0; i < size; ++i) names.push_back(std::string("x").append(std::to_string(i)));
  return names;
}

void check_name(const std::vector<std::string>& earlier, const std::string& name, int size) {
  if (name.empty()) throw ComponentError("a component needs a name", "/components");
  if (name.find_first_of("./ ") != std::string::npos)
    throw ComponentError("'" + name + "': a component's name has no '.', '/' or space, which metrics use",
                         "/components");
  if (std::find(earlier.begin(), earlier.end(), name) != earlier.end())
    throw ComponentError("two components are named '" + name + "'", "/components");
  if (size > 1 && name == norm_name)
    throw ComponentError("'norm' is the length of the whole vector; name the component otherwise", "/components");
}

std::vector<std::string> component_names(const Parameters& parameters, int size) {
  if (!parameters.has("components")) return default_names(size);
  std::vector<std::string> names;
  for (const auto& element : parameters.list("components")) {
    check_name(names, element.text, size);
    names.push_back(element.text);
  }
  if (static_cast<int>(names.size()) != size)
    throw ComponentError(std::to_string(names.size()) + " names for " + std::to_string(size) + " components",
                         "/components");
  return names;
}

}  // namespace

ComponentSpec VectorBlock::spec() {
  ComponentSpec spec;
  spec.type = "vector";
  spec.summary =
      "A vector of quantities with one unit: bias, scale factor, lever arm, misalignment or another linear state.";
  spec.kind = "vector:*:*";
  spec.parameters = {
      parameter::integer("size").at_least(1).at_most(largest_size).required().about("number of components"),
      parameter::text("unit").defaults("\"1\"").about(
          "SI unit of every component, for example \"rad/s\"; for mixed quantities \"1\", with plain SI numbers"),
      parameter::list("components", parameter::text("name").about("name of a component"))
          .about("names of the components; default: x for one, x y z for three, else x0 x1 …"),
      parameter::text("display").defaults("\"\"").about("unit in tables, for example \"deg/h\"; \"\" for the SI unit"),
  };
  spec.example = R"json({"size": 3, "unit": "rad/s", "display": "deg/h", "init": {"x": 0, "y": 0, "z": 0},
    "sigma": "20 deg/h"})json";
  return spec;
}

VectorBlock::VectorBlock(const Binding& binding) {
  const Parameters& parameters = binding.parameters();
  const int size = static_cast<int>(parameters.integer("size"));
  const std::string& unit = parameters.text("unit");
  const std::string& display = parameters.text("display");
  declaration_.kind = "vector:" + std::to_string(size) + ":" + unit;
  declaration_.starts_at_zero = true;
  declaration_.stored_size = size;
  declaration_.error_display_unit = display;
  for (const std::string& name : component_names(parameters, size)) {
    declaration_.error.push_back({name, unit});
    Output output;
    output.name = name;
    output.unit = unit;
    output.display_unit = display;
    output.text = "component " + name;
    declaration_.outputs.push_back(std::move(output));
  }
  if (size > 1) {
    std::vector<int> all(static_cast<std::size_t>(size));
    std::iota(all.begin(), all.end(), 0);
    declaration_.norms.push_back({norm_name, std::move(all)});
  }
}

}  // namespace binnacle::core
