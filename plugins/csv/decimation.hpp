// SPDX-License-Identifier: Apache-2.0
// "every": several samples become one.
#pragma once

#include "csv_table.hpp"

namespace binnacle::csv {

/// Of levels every so many samples one stays, the first too, as it is. Samples with intervals are put together: the mean of
/// rates over the joint time, the sum of increments, the last of levels; a gap, and the end, closes a sample early, so that no
/// motion is lost.
void thin_out(const Layout& layout, Table& table);

}  // namespace binnacle::csv
