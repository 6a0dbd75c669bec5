// SPDX-License-Identifier: Apache-2.0
// Transitional: models and callers written against pointers and places in lists, on top of the interface by handle.
// Deleted when the last of them is migrated.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>

#include "binnacle/derived_block.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/process_model.hpp"

namespace binnacle::legacy {

inline constexpr std::size_t most_ports = 32;

struct Context {
  Time t = no_time;
  const double* driving_rates = nullptr;
};

struct Linearization {
  int rows = 0;
  double* residual = nullptr;
  const MatrixView* H = nullptr;  // per entry of read_ports
  MatrixView R;
  std::int64_t* row_keys = nullptr;
};

struct ProcessOutput {
  double* const* x_plus = nullptr;
  double* const* transition = nullptr;
  double* const* noise = nullptr;
};

struct ContinuousOutput {
  double* const* dynamics = nullptr;
  double* const* noise = nullptr;
};

// ---- old models behind the new calls

class MeasurementModel : public binnacle::MeasurementModel {
 public:
  const MeasurementDeclaration& declaration() const noexcept override = 0;
  virtual void start(std::byte* /*memory*/) const {}
  virtual Result linearize(const SampleView& sample, const SampleView* auxiliary, const double* const* x,
                           const Context& context, std::byte* memory, Linearization& out) const = 0;

  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const final {
    const auto& reads = declaration().read_ports;
    std::array<MatrixView, most_ports> H;
    assert(reads.size() <= most_ports && out.H);
    for (std::size_t i = 0; i < reads.size(); ++i) H[i] = out.H.pointers()[reads[i]];
    Linearization old{0, out.residual.data(), H.data(), out.R, out.row_keys.data()};
    const Result result = linearize(in.sample, in.auxiliary.pointers(), in.x.pointers(),
                                    Context{in.u.t, in.u.rates.data()}, in.memory.data(), old);
    out.rows = old.rows;
    return result;
  }

 protected:
  void initialise(const MemoryView& memory) const final { start(memory.data()); }
};

class ProcessModel : public binnacle::ProcessModel {
 public:
  const ProcessDeclaration& declaration() const noexcept override = 0;
  virtual void start(std::byte* /*memory*/) const {}
  virtual Result propagate(const Step& /*step*/, const double* const* /*x*/, std::byte* /*memory*/,
                           const ProcessOutput& /*out*/) const {
    return Result::failed("this model has no closed form");
  }
  virtual void linearized(const double* const* /*x*/, const ContinuousOutput& /*out*/) const {}

  Result propagate(const ProcessInput& in, binnacle::ProcessOutput& out) const final {
    return propagate(in.step, in.x.pointers(), in.memory.data(),
                     ProcessOutput{out.x.pointers(), out.phi.pointers(), out.Qd.pointers()});
  }
  void linearized(const ContinuousInput& in, binnacle::ContinuousOutput& out) const final {
    linearized(in.x.pointers(), ContinuousOutput{out.F.pointers(), out.GQGt.pointers()});
  }

 protected:
  void initialise(const MemoryView& memory) const final { start(memory.data()); }
};

class DerivedBlock : public binnacle::DerivedBlock {
 public:
  const DerivedDeclaration& declaration() const noexcept override = 0;
  virtual Result evaluate(const double* const* x, const Context& context, double* value, const MatrixView* J) const = 0;

  Result evaluate(const DerivedInput& in, DerivedOutput& out) const final {
    const auto& reads = declaration().read_ports;
    std::array<MatrixView, most_ports> J;
    assert(reads.size() <= most_ports);
    if (out.J)
      for (std::size_t i = 0; i < reads.size(); ++i) J[i] = out.J.pointers()[reads[i]];
    return evaluate(in.x.pointers(), Context{in.u.t, in.u.rates.data()}, out.value.data(), out.J ? J.data() : nullptr);
  }
};

// ---- old callers of new models

inline Result linearize(const binnacle::MeasurementModel& model, const SampleView& sample, const SampleView* auxiliary,
                        const double* const* x, const Context& context, std::byte* memory, Linearization& out) {
  const auto& declared = model.declaration();
  std::array<MatrixView, most_ports> H;
  for (std::size_t i = 0; i < declared.read_ports.size(); ++i)
    H[static_cast<std::size_t>(declared.read_ports[i])] = out.H[i];
  const MeasurementInput in{sample, auxiliary, x, {context.t, context.driving_rates}, memory, {}, {}};
  MeasurementOutput made{0,
                         {out.residual, declared.max_rows},
                         H.data(),
                         out.R,
                         {out.row_keys, out.row_keys ? static_cast<std::size_t>(declared.max_rows) : 0}};
  const Result result = model.linearize(in, made);
  out.rows = made.rows;
  return result;
}

inline Result propagate(const binnacle::ProcessModel& model, const Step& step, const double* const* x,
                        std::byte* memory, const ProcessOutput& out) {
  binnacle::ProcessOutput made{out.x_plus, out.transition, out.noise};
  return model.propagate(ProcessInput{step, x, {}, memory, {}}, made);
}

inline void linearized(const binnacle::ProcessModel& model, const double* const* x, const ContinuousOutput& out) {
  binnacle::ContinuousOutput made{out.dynamics, out.noise};
  model.linearized(ContinuousInput{x}, made);
}

inline Result evaluate(const binnacle::DerivedBlock& model, const double* const* x, const Context& context,
                       double* value, const MatrixView* J) {
  const auto& declared = model.declaration();
  std::array<MatrixView, most_ports> by_port;
  if (J)
    for (std::size_t i = 0; i < declared.read_ports.size(); ++i)
      by_port[static_cast<std::size_t>(declared.read_ports[i])] = J[i];
  DerivedOutput made{{value, declared.stored_size}, J ? PortJacobians(by_port.data()) : PortJacobians()};
  return model.evaluate(DerivedInput{x, {context.t, context.driving_rates}}, made);
}

}  // namespace binnacle::legacy
