// SPDX-License-Identifier: Apache-2.0
// The csv plugin: its components.
#include "binnacle/plugin.hpp"

#include "csv_source.hpp"

BINNACLE_PLUGIN("csv", "1.0.0", registry) { registry.add<binnacle::csv::CsvSource>(); }
