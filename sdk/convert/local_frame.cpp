// SPDX-License-Identifier: Apache-2.0
#include "local_frame.hpp"

#include "binnacle/geodesy.hpp"
#include "binnacle/unit.hpp"

namespace binnacle::convert {

namespace {

/// A number of SI, or a text with a unit.
double value_of(const results::Json& origin, const char* key, const char* unit) {
  const auto found = origin.find(key);
  if (found != origin.end() && found->is_number()) return found->get<double>();
  if (found != origin.end() && found->is_string())
    if (const auto quantity = parse_quantity(found->get<std::string>());
        quantity && quantity->dimension == parse_unit(unit)->dimension)
      return quantity->value;
  throw Refusal(std::string("/origin/") + key + " of the run's config is not a quantity in " + unit);
}

}  // namespace

LocalFrame::LocalFrame(const Place& origin)
    : origin_(geodesy::ecef_from_lla({origin.lat, origin.lon, origin.height})),
      C_en_(geodesy::C_en(origin.lat, origin.lon)) {}

std::optional<Place> origin_of(const results::Json& config) {
  const auto found = config.find("origin");
  if (found == config.end() || !found->is_object()) return {};
  const bool has_height = found->contains("height");
  return Place{value_of(*found, "lat", "rad"), value_of(*found, "lon", "rad"),
               has_height ? value_of(*found, "height", "m") : 0, "/origin of the run's config"};
}

}  // namespace binnacle::convert
