// SPDX-License-Identifier: Apache-2.0
// The stream plugin: its components.
#include "binnacle/plugin.hpp"

#include "csv_source.hpp"
#include "json_source.hpp"
#include "json_writer.hpp"

BINNACLE_TYPES("csv json json_writer");

BINNACLE_PLUGIN("stream", "1.0.0", registry) {
  registry.add<binnacle::stream::CsvSource>();
  registry.add<binnacle::stream::JsonSource>();
  registry.add<binnacle::stream::JsonWriter>();
}
