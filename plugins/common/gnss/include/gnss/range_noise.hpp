// SPDX-License-Identifier: Apache-2.0
// How far a pseudorange or a range rate is trusted: by its row, its elevation, its C/N0.
#pragma once

#include <optional>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/spec.hpp"
#include "gnss/corrections.hpp"

namespace binnacle::gnss {

/// σ² = (σ₀² + (σ_e / sin el)²) w(S) + (σ_S)² 10^((S_ref − S)/10) + (f · ionosphere)² + (URA)², S: C/N0 [dB-Hz]. What the row
/// itself gives replaces all of it.
///
/// Elevation: σ₀² + (σ_e / sin el)². C/N0: σ₀² + σ_S² 10^((S_ref − S)/10) is the SIGMA-ε model a + b 10^(−S/10) with
/// b = σ_S² 10^(S_ref/10) (Hartinger and Brunner, Variances of GPS phase observations: the SIGMA-ε model, GPS Solutions
/// 2 (1999) 35-43). w: Realini and Reguzzoni, goGPS: open source software for enhancing the accuracy of low-cost receivers
/// by single-frequency relative kinematic positioning, Meas. Sci. Technol. 24 (2013) 115010, equation (10).
class RangeNoise {
 public:
  enum class Of { pseudorange, range_rate };
  static std::vector<ParameterSpec> parameters(Of of, const char* default_sigma);
  RangeNoise(const Parameters& parameters, Of of);

  /// Whether a row without C/N0 has no variance, unless it gives one.
  bool needs_cn0() const noexcept { return by_cn0_ > 0 || weight_; }
  /// m² or m²/s². Not positive or NaN: the row has none that can be used.
  double variance(const Sighting& sighting) const;

 private:
  struct Weight {
    double s0, s1, a, A;  // dB-Hz, dB-Hz, dB-Hz, 1
    double at(double cn0) const;
  };

  Of of_;
  double sigma_, by_elevation_;
  double by_cn0_, cn0_reference_;
  std::optional<Weight> weight_;
  double ionosphere_ = 0, accuracy_ = 0;
};

}  // namespace binnacle::gnss
