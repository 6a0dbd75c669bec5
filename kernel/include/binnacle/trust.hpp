// SPDX-License-Identifier: Apache-2.0
// Trust: whether a filter's estimates hold, and what is against them.
#pragma once

#include <cstdint>

#include "binnacle/time.hpp"

namespace binnacle {

/// Of a filter so far. `ok`: nothing is against its estimates; `doubtful`: something does; `lost`: they do not hold.
enum class Verdict : unsigned char { ok, doubtful, lost };

constexpr const char* verdict_name(Verdict verdict) {
  constexpr const char* names[] = {"ok", "doubtful", "lost"};
  return names[static_cast<int>(verdict)];
}

/// What is against a filter's estimates. `figure` and `limit` are those of TrustReason.
enum class Doubt : unsigned char {
  locked_out,      ///< refused `figure` times in a row, and still: at least `limit`
  never_accepted,  ///< `figure` samples were judged, at least `limit`, and none was accepted
  mostly_refused,  ///< the share of rows that the gate refused, beyond `limit`
  nis,             ///< NIS over its rows, the mean of a window; `limit`: what noise as assumed would not exceed
  bias,            ///< mean of z = r / √S over a window; `limit` as above
  correlation,     ///< mean of z_k z_{k−1} over a window; `limit` as above
  recovered,  ///< the covariance was opened `figure` times since samples kept being refused; `limit` times for samples
              ///< beyond 5 sigma that no other measurement confirms
  was_locked_out,  ///< refused `figure` times in a row, at least `limit`; it passes again
  bridged,         ///< the longest hole in the driving input [s], longer than `limit`
  frozen,     ///< the longest time that the driving input repeated itself to the bit [s], longer than `limit`; or of a
              ///< measurement: so many refused samples in a row did
  unaided,    ///< no sample of any measurement was used
  silent,     ///< the longest time [s] without a sample of use, in which what the measurement sees became 3 times as
              ///< uncertain; at least `limit`
  restarted,  ///< started anew `figure` times; once, after a hole of `limit` s in the driving input; 0: for other reasons
  input_ended,  ///< measurements went on for `figure` s after the end of the driving input, longer than `limit`
  stopped,      ///< after a hole of `figure` s in the driving input, longer than `limit`, it could not start anew
  lagging,      ///< live estimates were up to `figure` s behind what had arrived, longer than the history, `limit`
  indefinite,  ///< of component `key` (a row of P) the share `figure` of its variance is left once the others are known,
               ///< less than −`limit`: a correlation beyond one, or another P that is no covariance
  scattered,   ///< a row scatters by `figure`, and claims the standard deviation `limit`; R of it was increased
  unresolved,  ///< an update saw `figure` times the variance of its noise, more than the digits of P resolve: `limit`
};

/// One reason against a filter's estimates; with the verdict `ok` a note: what happened did them no harm.
struct TrustReason {
  Doubt doubt = Doubt::locked_out;
  Verdict verdict = Verdict::doubtful;
  int measurement = -1;  // of FilterInfo::measurements; −1: of the filter itself
  int group = -1;        // of MeasurementInfo::groups; −1: of the measurement as a whole
  std::int64_t key = 0;  // of the row in that group
  Time since = no_time;
  double figure = 0;
  double limit = 0;
};

/// What became of one row (group of MeasurementInfo::groups, and key) of a measurement, and how its innovations r, of
/// variance S = H P⁻ Hᵀ + R, were distributed where it was used. Withheld samples do not count.
struct RowFigures {
  int group = 0;
  std::int64_t key = 0;
  std::int64_t used = 0;
  std::int64_t left_out = 0;  // of accepted samples, by a gate by row or key
  std::int64_t refused = 0;   // left out, or gated with its sample
  double mean = 0;            // of z = r / √S; 0 for a right model, as is the correlation
  double rms = 0;             // of z; 1 for a right model
  double correlation = 0;     // of z from one use to the next
  double sigma = 0;           // √(mean of R) as assumed, in the row's unit
  double fitting_sigma = 0;   // √(mean of r² − H P⁻ Hᵀ), or 0: with it, rms would be near 1
};

}  // namespace binnacle
