// SPDX-License-Identifier: Apache-2.0
// The fast path: a measurement model that is a C function, called without Python and without the GIL.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "models_binding.hpp"

namespace binnacle::python {

/// How many rows it wrote, or why none: −1 unsupported, −2 invalid, −3 failed. The package's docstring of cfunc() says what
/// each argument is.
using LinearizeFunction = std::int32_t (*)(double t, const double* constants, const double* fields,
                                           const double* row_fields, std::int32_t rows, const double* x, double* memory,
                                           double* residual, double* H, double* R);

class FastMeasurement {
 public:
  /// Throws ValueError where ports or rows are more than its buffers hold.
  FastMeasurement(LinearizeFunction function, const ModelBinding& declared, std::vector<Port> ports,
                  std::vector<Port> reads, int max_rows);
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const;

 private:
  int gather(const PortValues& x, double* all) const;
  void scatter(const double* H, MeasurementOutput& out) const;

  LinearizeFunction function_;
  std::vector<double> constants_;
  std::vector<Port> ports_, reads_;
  int max_rows_, stored_ = 0, dof_ = 0;
};

/// Of the class's attribute `linearize`; null where that is a method.
std::unique_ptr<FastMeasurement> fast_measurement(const ModelBinding& declared, std::vector<Port> ports,
                                                  std::vector<Port> reads, int max_rows);

/// The file of the library that has the code at the address; "" where it lies in none.
std::string library_at(std::uintptr_t address);

}  // namespace binnacle::python
