// SPDX-License-Identifier: Apache-2.0
#include "models_fast.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <array>

namespace binnacle::python {

namespace {

// On the stack of a call: the run loop allocates nothing.
constexpr int most_stored = 256, most_jacobian = 4096, most_rows = 64;

Result result_of(std::int32_t code) {
  switch (code) {
    case -1: return Result::unsupported("the C function answers -1: it does not apply here");
    case -2: return Result::invalid("the C function answers -2: it can not use the sample");
    default: return Result::failed("the C function answers that it failed");
  }
}

}  // namespace

FastMeasurement::FastMeasurement(LinearizeFunction function, const ModelBinding& declared, std::vector<Port> ports,
                                 std::vector<Port> reads, int max_rows)
    : function_(function),
      constants_(declared.constants),
      ports_(std::move(ports)),
      reads_(std::move(reads)),
      max_rows_(max_rows) {
  for (const Port port : ports_) stored_ += port.stored_size();
  for (const Port port : reads_) dof_ += port.dof();
  if (stored_ > most_stored || max_rows_ > most_rows || max_rows_ * dof_ > most_jacobian)
    throw py::value_error("a C function takes at most " + std::to_string(most_rows) + " rows, ports of " +
                          std::to_string(most_stored) + " numbers and Jacobians of " + std::to_string(most_jacobian));
}

int FastMeasurement::gather(const PortValues& x, double* all) const {
  int count = 0;
  for (const Port port : ports_) {
    std::copy_n(x[port].data(), port.stored_size(), all + count);
    count += port.stored_size();
  }
  return count;
}

void FastMeasurement::scatter(const double* H, MeasurementOutput& out) const {
  for (const Port port : reads_) {
    const MatrixView to = out.H[port];
    for (int j = 0; j < port.dof(); ++j, H += max_rows_)
      if (to) std::copy_n(H, max_rows_, to.data + static_cast<std::ptrdiff_t>(j) * to.stride);
  }
}

Result FastMeasurement::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  std::array<double, most_stored> x;
  std::array<double, most_jacobian> H;
  std::array<double, most_rows * most_rows> R;
  gather(in.x, x.data());
  const bool wants_H = static_cast<bool>(out.H);
  if (wants_H) std::fill_n(H.data(), max_rows_ * dof_, 0.0);
  std::fill_n(R.data(), max_rows_ * max_rows_, 0.0);
  const std::int32_t rows =
      function_(seconds(in.sample.t), constants_.data(), in.sample.fields, in.sample.row_fields, in.sample.rows,
                x.data(), reinterpret_cast<double*>(in.memory.data()), out.residual.data(), H.data(), R.data());
  if (rows < 0) return result_of(rows);
  out.rows = rows;
  if (rows > max_rows_) return Result::ok();  // the kernel says so
  if (wants_H) scatter(H.data(), out);
  for (int j = 0; j < rows; ++j)
    std::copy_n(R.data() + j * max_rows_, rows, out.R.data + static_cast<std::ptrdiff_t>(j) * out.R.stride);
  return Result::ok();
}

std::unique_ptr<FastMeasurement> fast_measurement(const ModelBinding& declared, std::vector<Port> ports,
                                                  std::vector<Port> reads, int max_rows) {
  const py::object function = declared.model().type.get().attr("linearize");
  if (!py::isinstance(function, py::module_::import("binnacle._models").attr("CFunction"))) return nullptr;
  const auto address = function.attr("address").cast<std::uintptr_t>();
  return std::make_unique<FastMeasurement>(reinterpret_cast<LinearizeFunction>(address), declared, std::move(ports),
                                           std::move(reads), max_rows);
}

std::string library_at(std::uintptr_t address) {
  Dl_info info{};
  return ::dladdr(reinterpret_cast<const void*>(address), &info) != 0 && info.dli_fname ? info.dli_fname : "";
}

}  // namespace binnacle::python
