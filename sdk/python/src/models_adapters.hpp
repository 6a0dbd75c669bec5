// SPDX-License-Identifier: Apache-2.0
// A component for each role that asks a Python object. Each call holds the GIL; what Python raises becomes a
// std::runtime_error with its traceback, as anything that a plugin throws.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "models_binding.hpp"
#include "models_call.hpp"
#include "models_fast.hpp"
#include "models_manifolds.hpp"

namespace binnacle::python {

/// What the adapters of all roles have: the object, its memory, the manifolds of its ports.
class PythonModel : public OnManifolds {
 public:
  PythonModel(const ModelClass& model, const Binding& binding, const NoiseBinding* noise = nullptr);
  /// The Python object. Holds the GIL.
  const py::object& object() const { return object_.get(); }

 protected:
  /// The method, with the arguments that it takes by name.
  Method method(const char* name) const;
  Port port(const std::string& name) const;
  /// Ports with a Jacobian: those that it declares, or all that are bound.
  std::vector<Port> read_ports() const;
  /// Throws where nothing says what differences on the port are.
  const Manifold& manifold_of(Port port) const;
  /// How far a component is moved for a difference.
  double step_of(Port port, const double* x, int component) const;
  /// Values by port, None where one is open.
  py::dict values(const double* const* by_port) const;
  MemoryLayout& layout() { return declared_->memory; }
  const MemoryLayout& layout() const { return declared_->memory; }
  const ModelBinding& declared() const { return *declared_; }
  const ModelClass& model() const { return declared_->model(); }

  PythonNames names_;
  std::vector<Port> ports_;

 private:
  std::shared_ptr<ModelBinding> declared_;
  Held object_;
  std::vector<Held> port_names_;
};

class PythonMeasurement : public PythonModel, public MeasurementModel {
 public:
  PythonMeasurement(const ModelClass& model, const Binding& binding);
  Result linearize(const MeasurementInput& in, MeasurementOutput& out) const override;

 protected:
  void initialise(const MemoryView& memory) const override;

 private:
  struct Answer;
  void declare();
  Answer ask(const MeasurementInput& in, const double* const* x, std::byte* memory, bool wants_H,
             bool leaves_notes) const;
  Result linearize_in_python(const MeasurementInput& in, MeasurementOutput& out) const;
  py::dict extras(const MeasurementInput& in, py::dict& memory, py::list& notes, bool wants_H) const;
  Result write_H(const Answer& answer, MeasurementOutput& out) const;
  Result differentiate(const MeasurementInput& in, const std::byte* before, const Answer& nominal,
                       MeasurementOutput& out) const;

  std::unique_ptr<FastMeasurement> fast_;
  Method linearize_;
  SampleNames sample_;
  std::vector<SampleNames> inputs_;
  int covariance_dof_ = 0;
  std::vector<Port> reads_;
};

class PythonProcess : public PythonModel, public ProcessModel {
 public:
  PythonProcess(const ModelClass& model, const Binding& binding);
  Result propagate(const ProcessInput& in, ProcessOutput& out) const override;

 protected:
  void initialise(const MemoryView& memory) const override;

 private:
  struct Answer;
  struct Block {
    Port to, from;
    PhiBlock phi = {};
    QBlock q = {};
  };
  void declare();
  Result propagate_in_python(const ProcessInput& in, ProcessOutput& out) const;
  Answer ask(const ProcessInput& in, const double* const* x, std::byte* memory, bool wants_Phi,
             bool leaves_notes) const;
  void write_Phi(const Answer& answer, ProcessOutput& out) const;
  void write_Qd(const Answer& answer, ProcessOutput& out) const;
  void differentiate(const ProcessInput& in, const std::vector<const double*>& x, const std::byte* before,
                     const Answer& nominal, ProcessOutput& out) const;
  void differentiate_by(Port from, const std::vector<const Block*>& blocks, const ProcessInput& in,
                        const std::vector<const double*>& x, const std::byte* before, const Answer& nominal,
                        ProcessOutput& out) const;
  void refuse_others(const py::dict& blocks, std::size_t found, const char* what, const char* how) const;
  py::tuple key_of(const Block& block) const;

  Method propagate_;
  SampleNames sample_;
  std::vector<SampleNames> inputs_;
  std::vector<Port> advanced_;
  std::vector<Block> transition_, noise_;
};

class PythonNoise : public PythonModel, public NoiseEstimator {
 public:
  PythonNoise(const ModelClass& model, const Binding& binding, const NoiseBinding& noise);
  void estimate(const Innovation& in, MatrixView R) const override;
  void after(const AfterUpdate& in) const override;

 protected:
  void initialise(const MemoryView& memory) const override;

 private:
  Method estimate_, after_;
};

class PythonDerived : public PythonModel, public DerivedBlock {
 public:
  PythonDerived(const ModelClass& model, const Binding& binding);
  Result evaluate(const DerivedInput& in, DerivedOutput& out) const override;

 private:
  struct Answer;
  Answer ask(const DerivedInput& in, const double* const* x, bool wants_J, bool leaves_notes) const;
  Result evaluate_in_python(const DerivedInput& in, DerivedOutput& out) const;
  Result differentiate(const DerivedInput& in, const std::vector<const double*>& x, const Answer& nominal,
                       DerivedOutput& out) const;

  Method evaluate_;
  std::vector<Port> reads_;
};

class PythonTransform : public PythonModel, public Transform {
 public:
  PythonTransform(const ModelClass& model, const Binding& binding);
  void on(const TransformInput& in, Emitter& out) const override;

 protected:
  void initialise(std::uint64_t seed, const MemoryView& memory) const override;

 private:
  void emit(const py::handle& emitted, const SampleView& from, Emitter& out, std::vector<bool>& has_emitted) const;
  std::size_t channel_named(const std::string& name) const;
  void write_fields(const py::dict& fields, const ChannelDeclaration& channel, SampleWriter& writer) const;

  Method on_;
  Held emission_;
  std::vector<int> covariance_dof_;
  std::vector<SampleNames> inputs_;
};

}  // namespace binnacle::python
