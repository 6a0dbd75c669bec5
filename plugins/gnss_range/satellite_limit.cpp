// SPDX-License-Identifier: Apache-2.0
// How many satellites of an epoch are used: always, and in stretches of time.
#include "satellite_limit.hpp"

#include <algorithm>

#include "gnss/corrections.hpp"

namespace binnacle::gnss_range {

std::vector<ParameterSpec> SatelliteLimit::parameters() {
  using namespace parameter;
  return {integer("max_satellites")
              .at_least(1)
              .at_most(gnss::most_rows)
              .defaults("32")
              .about("largest number of rows of an epoch; of more satellites, the highest are used"),
          integer("min_satellites")
              .at_least(1)
              .at_most(8)
              .defaults("1")
              .about("least number of satellites; epochs with fewer are unsupported; 4: as a receiver that needs four "
                     "for its own position"),
          list("cuts",
               object("cut", {time("from").required().about("start of the interval"),
                              time("to").required().about("end of the interval"),
                              integer("satellites").at_least(0).required().about("largest number of satellites used")}))
              .about("intervals with fewer satellites, as under a shaded sky; the highest satellites are used")};
}

SatelliteLimit::SatelliteLimit(const Parameters& parameters)
    : most_(static_cast<int>(parameters.integer("max_satellites"))),
      fewest_(static_cast<int>(parameters.integer("min_satellites"))) {
  if (!parameters.has("cuts")) return;
  const auto& list = parameters.list("cuts");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Parameters cut(list[i]);
    cuts_.push_back(
        {cut.time("from"), cut.time("to"), static_cast<int>(std::min<std::int64_t>(cut.integer("satellites"), most_))});
    if (cuts_.back().from > cuts_.back().to)
      throw ComponentError("a cut ends after it begins", "/cuts/" + std::to_string(i));
  }
}

int SatelliteLimit::at(Time t) const {
  int limit = most_;
  for (const Cut& cut : cuts_)
    if (t >= cut.from && t <= cut.to) limit = std::min(limit, cut.satellites);
  return limit;
}

}  // namespace binnacle::gnss_range
