// SPDX-License-Identifier: Apache-2.0
// MeasurementModel: what is seen of the state.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/declaration.hpp"
#include "binnacle/eigen.hpp"
#include "binnacle/model_input.hpp"
#include "binnacle/result.hpp"
#include "binnacle/sample.hpp"
#include "binnacle/view.hpp"

namespace binnacle {

/// A run of residual rows that belong together. Written with the functions of the namespace `rows`.
///
/// When the rows are an error in the dof of the block on port `port` (a position fix: z ⊟ x), say so: withheld samples
/// are then scored with that block's names and norms. Otherwise port is −1 and `unit` specifies the unit of the rows.
struct ResidualGroup {
  std::string name;
  int first_row = 0;
  int rows = 0;  // 0: all rows there are (a model with a variable number of like rows)
  std::string unit;
  int port = -1;
};

namespace rows {

/// As many rows as the block on `port` has error components: an error of that block.
inline ResidualGroup of(std::string name, Port port) { return {std::move(name), 0, port.dof(), {}, port.index()}; }
/// `count` rows with this unit.
inline ResidualGroup these(std::string name, int count, std::string unit) {
  return {std::move(name), 0, count, std::move(unit), -1};
}
/// However many rows a sample has, all with this unit.
inline ResidualGroup like(std::string name, std::string unit) { return {std::move(name), 0, 0, std::move(unit), -1}; }

}  // namespace rows

/// What a bound measurement model will do at most:
///
///     declaration_.rows(3).reads(velocity_).reads(lever_arm_).group(rows::of("velocity", velocity_));
struct MeasurementDeclaration : MemoryDeclaration, PortReader<MeasurementDeclaration> {
  int max_rows = 0;
  std::vector<ResidualGroup> groups;
  bool needs_covariance = false;

  /// The largest number of rows.
  MeasurementDeclaration& rows(int most) {
    max_rows = most;
    return *this;
  }
  /// The next rows, those of the groups before it first.
  MeasurementDeclaration& group(ResidualGroup next) {
    next.first_row = 0;
    for (const auto& before : groups) {
      if (before.rows == 0) throw std::logic_error("group '" + before.name + "' takes all rows; none are left");
      next.first_row += before.rows;
    }
    groups.push_back(std::move(next));
    return *this;
  }
  /// MeasurementInput::P is there, for the ports that are read.
  MeasurementDeclaration& wants_covariance() {
    needs_covariance = true;
    return *this;
  }
};

/// What linearize() is given: a sample, and the state at its time.
struct MeasurementInput {
  SampleView sample;           // the fields declared in the spec
  AuxiliarySamples auxiliary;  // of the channels of ComponentSpec::inputs
  PortValues x;                // stored values (derived ports: the derived value)
  Driving u;
  MemoryView memory;  // what is written to it is kept only when the sample ends as `accepted`
  PortCovariance P;
  Notes notes;
};

/// Where a linearized measurement is written. The kernel zeroes H and R before the call.
struct MeasurementOutput {
  int rows = 0;                        // set by the model: 0…max_rows; 0: the sample is unsupported
  VectorView residual;                 // r = z ⊟ h(x̂), max_rows
  PortJacobians H;                     // ∂h/∂δ of a port that is read, max_rows × dof(port)
  MatrixView R;                        // nominal noise covariance, max_rows × max_rows, both triangles
  std::span<std::int64_t> row_keys{};  // who a row is (a satellite), max_rows; 0…max_rows−1 on entry
};

/// Relates a sample to blocks.
class MeasurementModel : public DeclaredModel<MeasurementDeclaration> {
 public:
  /// Residual, R and, where out.H is wanted, H: without it residual and R are the same to the bit.
  virtual Result linearize(const MeasurementInput& in, MeasurementOutput& out) const = 0;
};

}  // namespace binnacle
