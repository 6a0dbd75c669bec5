// SPDX-License-Identifier: Apache-2.0
#include "drive_study.hpp"

#include <filesystem>

#include "catch.hpp"

namespace binnacle::test {

void write_drive(const Workbench& bench) {
  bench.write("drive.json", R"~({
  "extends": ")~" + std::string(BINNACLE_TEST_PROJECT) +
                                R"~(/configs/quickstart.json",
  "sources": { "drive": { "segments": [
    { "do": "still", "duration": "2 s" },
    { "do": "accelerate", "to": "8 m/s", "acceleration": "2 m/s^2" },
    { "do": "turn", "angle": "60 deg", "rate": "12 deg/s" },
    { "do": "straight", "duration": "4 s" } ] } },
  "evaluate": { "after": "start+2 s", "metrics": ["ins/position.horizontal/rms"] },
  "study": {
    "runs": 6, "seed": 7,
    "metrics": ["ins/position.horizontal/rms", { "metric": "ins/attitude.yaw/final", "unit": "mil" }, "ins/position/nees"],
    "dimensions": {
      "gyro": { "good": { "filters": { "ins": { "process": { "strapdown": { "gyro_noise": "0.3 deg/sqrt(h)" } } } } },
                "bad": { "filters": { "ins": { "process": { "strapdown": { "gyro_noise": "30 deg/sqrt(h)" } } } } } },
      "bias": { "on": {},
                "off": { "filters": { "ins": { "blocks": { "accel_bias": null },
                                               "process": { "accel_drift": null, "strapdown": { "blocks": { "accel_bias": null } } } } } } } },
    "table": { "title": "Yaw", "rows": ["good", "bad"], "columns": ["on", "off"], "metric": "ins/attitude.yaw/final",
               "unit": "arcmin" }
  }
})~");
}

void check_same_files(const Workbench& bench, const std::string& a, const std::string& b) {
  for (const char* name : {"study.csv", "table.csv", "study.json", "study.nc"})
    CHECK(read_file(bench.path(a + "/" + name)) == read_file(bench.path(b + "/" + name)));
}

std::size_t lines_in(const std::string& path) {
  if (!std::filesystem::exists(path)) return 0;
  std::size_t lines = 0;
  for (const char c : read_file(path)) lines += c == '\n';
  return lines;
}

}  // namespace binnacle::test
