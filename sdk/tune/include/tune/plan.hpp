// SPDX-License-Identifier: Apache-2.0
// The section "tune" of a config.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/config.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/parameters.hpp"

namespace binnacle::tune {

using Json = nlohmann::ordered_json;

/// A number of the config, in the config's own unit.
struct Place {
  std::string pointer;  // of a number of a list: of the list
  int element = -1;     // of the list
  double value = 0;
  std::string unit;  // "" where the config has a plain number

  std::string name() const { return element < 0 ? pointer : join_pointer(pointer, static_cast<std::size_t>(element)); }
};

/// What is tuned. u is what the optimizer sees: ln θ, or θ / step.
struct Parameter {
  Place place;
  std::vector<Place> ties;  // keep their ratio to it
  bool has_start = false;   // of its own: it need not stand in the config
  bool is_log = true;
  double step = 1;              // of a linear scale
  double lower = 0, upper = 0;  // of u
  bool has_bounds = false;      // of its own
  struct Prior {
    double mean, sigma;  // of u
  };
  std::optional<Prior> prior;

  double u_of(double value) const;
  double value_of(double u) const;
};

enum class Objective { likelihood, withheld_nll, withheld_rms, metric };

struct Member {
  std::filesystem::path config;
  LoadOptions load;
};

struct Plan {
  std::string title;
  std::vector<Parameter> parameters;
  Objective objective = Objective::likelihood;
  std::string metric;
  std::vector<Member> over, unseen;
  std::optional<When> until;  // of `over`: what comes later is not used, and is judged
  int restarts = 0;
};

/// Whether the config has a "tune" at all.
bool is_in(const Config& config);
/// Reads and checks it. Throws ConfigError.
Plan read_plan(const std::filesystem::path& config, const LoadOptions& options);

/// JSON of a value in the place's own unit: 0.5, or "0.5 m".
Json shown_value(const Place& place, double value);
/// What LoadOptions::sets needs for these values of u.
std::vector<std::string> sets_of(const std::vector<Parameter>& parameters, const std::vector<double>& u,
                                 const Json& config);
/// The same as a merge patch: only of the parameters that `is_in` names. Lists are whole.
Json patch_of(const std::vector<Parameter>& parameters, const std::vector<double>& u, const std::vector<bool>& is_in,
              const Json& config);

}  // namespace binnacle::tune
