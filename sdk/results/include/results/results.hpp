// SPDX-License-Identifier: Apache-2.0
// Results: what --out left in a folder, as the report and other tools read it.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/noise_estimator.hpp"
#include "binnacle/time.hpp"
#include "results/seconds.hpp"

namespace binnacle::results {

using Json = nlohmann::ordered_json;

/// A file could not be written; one line that says why, without its name.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Loads the NetCDF library, which else the first file does: called before work whose results are written at its end.
/// Throws WriteError where it cannot be loaded.
void load_netcdf();

/// As summary.json has them.
inline constexpr std::array<const char*, outcome_count> outcome_names = {"accepted",    "gated",   "late",
                                                                         "unsupported", "invalid", "withheld",
                                                                         "rejected"};

/// A readable output of a block over time, and its 1-σ. SI.
struct Estimate {
  std::string block;
  std::string output;
  std::string unit;
  std::string display_unit;
  bool is_angle = false;       // may jump by a turn
  std::vector<double> values;  // as long as FilterResults::t
  std::vector<double> sigma;
  std::string kind = {};  // of the block: "position"; empty where it is not known
};

/// What is recorded beside the outputs of blocks: adapted noise, an implied state, a local coordinate.
struct Other {
  std::string name;  // "match.velocity.noise"
  std::string unit;
  std::vector<double> values;  // as long as FilterResults::t
};

/// An error against a reference or a withheld sample, truth − estimate (a norm: its length); also a NEES, an adapted √R.
struct Error {
  std::string name;  // "position.horizontal", "position.nees", "match.velocity.noise"
  std::string unit;
  std::string display_unit;
  std::vector<double> t;  // s
  std::vector<double> values;
  std::vector<double> sigma;  // what the filter thought of it; empty where that is not known
  bool is_length = false;     // a norm, never negative
  bool is_component = false;  // of a block's error, a column of one variable in run.nc
};

/// The fate of every sample offered to one measurement, and of its rows.
struct Updates {
  struct Group {
    std::string name;
    std::string unit;
  };
  std::string measurement;
  std::vector<Group> groups;
  std::vector<double> t;  // s, one per sample
  std::vector<Outcome> outcome;
  std::vector<std::string> reason;  // empty when accepted
  std::vector<double> nis;          // NaN when the model refused the sample
  std::vector<std::int32_t> rows;   // that nis is of
  // Row by row through all samples, `rows` of each:
  std::vector<std::int32_t> group;  // index in groups
  std::vector<std::int64_t> key;
  std::vector<double> residual;
  std::vector<double> sigma;  // √ of the diagonal of S = H P⁻ Hᵀ + R
  std::vector<double> noise;  // √ of the diagonal of R, as the noise estimator returned it
};

struct FilterResults {
  std::string name;
  std::vector<double> t;  // s, of the estimates
  std::vector<Estimate> estimates;
  std::vector<Other> others;  // empty where an older version wrote the file
  std::vector<Error> errors;
  std::vector<Updates> updates;
};

/// A run: DIR/run.nc with its summary and config.
struct RunResults {
  Json summary, config;
  Json provenance;  // { "version", "command", "seed", "run", "plugins": [ { "name", "version", "path" } ], "created" }
  std::vector<FilterResults> filters;
};

/// A study: DIR/study.nc.
struct StudyResults {
  Json figures, config;  // as study.json; the config without its variants' patches
  Json provenance;
  struct Metric {
    std::string name;
    std::string unit;  // display; values are SI
    std::string si_unit;
  };
  std::vector<std::string> variants;
  std::vector<Metric> metrics;
  std::size_t runs = 0;
  std::vector<double> values;  // [variant][metric][run], SI; NaN where a run broke or has no such metric
};

/// What there is in the folder: a run, a study, or both. Throws std::runtime_error, one line that names the file, what
/// is wrong with it and what to do, where there is neither or one is damaged.
struct Results {
  std::optional<RunResults> run;
  std::optional<StudyResults> study;
};
Results read(const std::filesystem::path& folder);
/// The study there, if there is one; throws as read() does.
std::optional<StudyResults> read_study(const std::filesystem::path& folder);

}  // namespace binnacle::results
