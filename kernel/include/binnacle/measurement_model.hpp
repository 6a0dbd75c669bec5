// SPDX-License-Identifier: Apache-2.0
// MeasurementModel: what is seen of the state.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/result.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// What models and derived blocks may know besides the state (the `u` of the design): the time, and the mean rates of
/// the last driving interval, in the order of ComponentSpec::driving_rates. `driving_rates` is null until the first interval has ended
/// and for components that declare none.
struct Context {
  Time t = no_time;
  const double* driving_rates = nullptr;
};

/// A run of residual rows that belong together.
///
/// When the rows are an error in the dof of the block on port `port` (a position fix: z ⊟ x), say so: withheld samples
/// are then scored with that block's names and norms. Otherwise port is −1 and `unit` tells the unit of the rows.
struct ResidualGroup {
  std::string name;
  int first_row = 0;
  int rows = 0;  // 0: all rows there are (a model with a variable number of like rows)
  std::string unit;
  int port = -1;
};

struct MeasurementDeclaration {
  int max_rows = 0;
  std::vector<int> read_ports;  // ports with a Jacobian block, by index in the spec's order; only bound ones
  std::vector<ResidualGroup> groups;
  std::size_t memory_bytes = 0;  // in the arena; zeroed, then initialised by start()
};

/// Where a linearized measurement is written. The kernel zeroes H and R before the call.
struct Linearization {
  int rows = 0;                      // set by the model: 0…max_rows; 0: none of this sample's
  double* residual = nullptr;        // r = z ⊟ h(x̂), max_rows
  const MatrixView* H = nullptr;     // per entry of `read_ports`: ∂h/∂δ of that port, max_rows × dof(port)
  MatrixView R;                      // nominal noise covariance, max_rows × max_rows, both triangles
  std::int64_t* row_keys = nullptr;  // who a row is (a satellite); 0…rows−1 on entry
};

/// Relates a sample to blocks. Immutable; never throws, never allocates, touches only what it is handed.
class MeasurementModel {
 public:
  virtual ~MeasurementModel() = default;

  virtual const MeasurementDeclaration& declaration() const noexcept = 0;
  virtual void start(std::byte* /*memory*/) const {}

  /// sample: the fields declared in the spec. auxiliary[i]: the latest sample on the i-th declared auxiliary channel.
  /// x[port]: stored values (derived ports: the derived value). What is written to `memory` is kept only when the
  /// sample ends as `accepted`.
  virtual Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                           const Context& context, std::byte* memory, Linearization& out) const = 0;
};

}  // namespace binnacle
