// SPDX-License-Identifier: Apache-2.0
// The first byte chooses how the columns are described, and whether a row that cannot be read is skipped.
#include "../reader.hpp"
#include "csv/csv_source.hpp"

namespace binnacle::fuzz {

namespace {

using nlohmann::json;

json column(const char* number, const char* unit) { return {{"column", number}, {"unit", unit}}; }

json described(unsigned which) {
  json scaled = column("3", "deg/s");
  scaled.update(json{{"scale", -0.061}, {"offset", 0.5}, {"kind", "rate"}});
  switch (which) {
    case 0: return {{"header", false}, {"columns", {{"a", column("2", "deg")}, {"b", column("3", "m")}}}};
    case 1:
      return {{"header", false},
              {"delimiter", ";"},
              {"time", {{"column", "1"}, {"format", "iso8601"}}},
              {"origin", {{"lat", 0.85}, {"lon", 0.15}, {"height", 115}}},
              {"local", {{"north", column("2", "m")}, {"east", column("3", "km")}, {"up", column("4", "m")}}}};
    case 2:
      return {{"header", false},
              {"delimiter", ";"},
              {"decimal", ","},
              {"time", {{"column", "2"}, {"date_column", "1"}, {"date_order", "dmy"}}},
              {"columns", {{"w", scaled}}}};
    case 3:
      return {{"header", false},
              {"time", {{"column", "2"}, {"week_column", "1"}, {"unit", "ms"}}},
              {"epoch", "1970-01-01"},
              {"columns", {{"a", column("3", "m")}}}};
    default: return {{"columns", {{"wx", {{"unit", "rad"}, {"kind", "increment"}}}, {"wy", {{"unit", "rad/s"}}}}}};
  }
}

}  // namespace

void try_bytes(std::string_view bytes) {
  if (bytes.empty()) return;
  const auto choice = static_cast<unsigned char>(bytes.front());
  json parameters = described(choice % 6);
  parameters["invalid_rows"] = choice / 6 % 2 == 0 ? "skip" : "error";
  read_file<csv::CsvSource>(choice % 6 == 5 ? "data.csv.gz" : "data.csv", bytes.substr(1), parameters);
}

}  // namespace binnacle::fuzz
