// SPDX-License-Identifier: Apache-2.0
// The csv plugin: its components.
#include "binnacle/plugin.hpp"

#include "csv_source.hpp"
#include "csv_writer.hpp"

BINNACLE_TYPES("csv csv_writer");

BINNACLE_PLUGIN("csv", "1.1.0", registry) {
  registry.add<binnacle::csv::CsvSource>();
  registry.add<binnacle::csv::CsvWriter>();
}
