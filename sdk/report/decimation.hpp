// SPDX-License-Identifier: Apache-2.0
// Which samples of a long series are shown: those that a plot of all would be seen by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace binnacle::report {

using Series = std::span<const double>;

/// Indices, ascending, no more than `most` (at least 2 + 2 per series are allowed): all of them where there are so few;
/// else the first, the last, and where each series is least and greatest in each of equally many samples. So every point
/// of a plot is a sample, and no peak is lost. All series are of one length; NaN is passed over.
std::vector<std::size_t> extremes(const std::vector<Series>& series, std::size_t most);

/// As extremes(), and with the first sample of each kind in every stretch. `kinds` is as long as the series, its values
/// are small and not negative.
std::vector<std::size_t> extremes_of_kinds(const std::vector<Series>& series, std::span<const std::uint8_t> kinds,
                                           std::size_t most);

/// As extremes_of_kinds(), of stretches of time, all `width` long: what is kept of a series may be thinned again in stretches
/// twice as long, and is what would be kept of the whole.
std::vector<std::size_t> extremes_in_time(const std::vector<Series>& series, std::span<const std::uint8_t> kinds,
                                          Series t, double width);

/// Indices, ascending, of a path's points that lie at least `step` from the one kept before; the first and the last too.
std::vector<std::size_t> spaced(Series x, Series y, double step);

}  // namespace binnacle::report
