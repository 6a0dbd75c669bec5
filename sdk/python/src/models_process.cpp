// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "models_adapters.hpp"
#include "models_spec.hpp"
#include "wording/wording.hpp"

namespace binnacle::python {

namespace {

using wording::as_size;

std::string text_of(const py::handle& value) { return py::str(value).cast<std::string>(); }

py::dict dict_of(const py::object& value, const std::string& what) {
  if (!py::isinstance<py::dict>(value))
    throw py::type_error(what + " is " + py::repr(value).cast<std::string>() + "; it is a dict");
  return py::reinterpret_borrow<py::dict>(value);
}

}  // namespace

struct PythonProcess::Answer {
  Result result;
  std::vector<std::vector<double>> x;  // by port that is advanced
  py::object Phi, Qd;
};

PythonProcess::PythonProcess(const ModelClass& model, const Binding& binding) : PythonModel(model, binding) {
  in_python([&] {
    sample_ = SampleNames(model.spec.fields);
    for (const auto& input : model.spec.inputs) inputs_.emplace_back(input.fields);
    for (std::size_t i = 0; i < ports_.size(); ++i)
      if (ports_[i].is_bound() && model.spec.ports[i].access == PortAccess::advances) advanced_.push_back(ports_[i]);
    declare();
    propagate_ = method("propagate");
  });
}

void PythonProcess::declare() {
  const auto add_transition = [&](Port to, Port from) {
    if (to.is_bound() && from.is_bound()) transition_.push_back({to, from, declaration_.couples(to, from), {}});
  };
  const auto add_noise = [&](Port to, Port from) {
    if (to.is_bound() && from.is_bound()) noise_.push_back({to, from, {}, declaration_.adds_noise(to, from)});
  };
  if (declared().couples)
    for (const auto& [to, from] : *declared().couples) add_transition(port(to), port(from));
  else
    for (const Port to : advanced_)
      for (const Port from : ports_) add_transition(to, from);
  if (declared().adds_noise)
    for (const auto& [to, from] : *declared().adds_noise) add_noise(port(to), port(from));
  else
    for (const Port to : advanced_) add_noise(to, to);
  declaration_.keeps_array<std::uint64_t>(layout().words());
}

void PythonProcess::initialise(const MemoryView& memory) const { layout().write_initial(memory.data()); }

Result PythonProcess::propagate(const ProcessInput& in, ProcessOutput& out) const {
  return in_python([&] { return propagate_in_python(in, out); });
}

PythonProcess::Answer PythonProcess::ask(const ProcessInput& in, const double* const* x, std::byte* memory,
                                         bool wants_Phi, bool leaves_notes) const {
  py::dict kept = layout().read(memory), extras;
  py::list notes, samples;
  if (propagate_.takes("memory")) extras["memory"] = kept;
  if (propagate_.takes("notes")) extras["notes"] = notes;
  if (propagate_.takes("wants_Phi")) extras["wants_Phi"] = wants_Phi;
  if (propagate_.takes("auxiliary")) extras["auxiliary"] = to_python(names_, in.auxiliary, model().spec, inputs_);
  for (const InputSample& sample : in.step.samples)
    samples.append(names_.sample.get()(sample_.fields(sample.fields), sample.t1, sample.t0, 0, py::none(), sample.dt,
                                       sample.bridges));
  const py::object step = names_.step.get()(in.step.t0, in.step.t1, in.step.dt, samples, in.step.bridges);
  const py::object answer = propagate_(extras, values(x), step);
  layout().write(kept, memory);
  if (leaves_notes) leave(in.notes, notes);
  if (const auto refused = refusal_of(names_, answer)) return {*refused, {}, {}, {}};
  if (!py::isinstance<py::tuple>(answer) || py::len(answer) != 3)
    throw py::type_error("propagate gives " + py::repr(answer).cast<std::string>() +
                         "; it gives (x, Phi, Qd), or binnacle.failed(\"why\")");
  const auto parts = py::reinterpret_borrow<py::tuple>(answer);
  const py::dict x_plus = dict_of(parts[0], "x");
  Answer made{Result::ok(), {}, parts[1], parts[2]};
  for (const Port port : advanced_) {
    const std::string& name = model().spec.ports[as_size(port.index())].name;
    if (!x_plus.contains(name.c_str()))
      throw py::key_error("x has no value of port '" + name + "', which the model advances");
    auto& value = made.x.emplace_back(as_size(port.stored_size()));
    copy_vector(x_plus[name.c_str()], "x of '" + name + "'", port.stored_size(), value.data());
  }
  if (x_plus.size() != advanced_.size())
    throw py::key_error("x has values of " + py::str(py::list(x_plus)).cast<std::string>() +
                        ": more than the ports that the model advances");
  return made;
}

Result PythonProcess::propagate_in_python(const ProcessInput& in, ProcessOutput& out) const {
  const std::size_t bytes = layout().words() * sizeof(std::uint64_t);
  const std::vector<std::byte> before(in.memory.data(), in.memory.data() + bytes);
  std::vector<const double*> x;
  std::vector<std::vector<double>> copies;  // out.x may be the same memory
  for (const Port port : ports_) {
    auto& copy = copies.emplace_back();
    if (in.x[port]) copy.assign(in.x[port].data(), in.x[port].data() + port.stored_size());
    x.push_back(port.is_bound() ? copy.data() : nullptr);
  }
  const bool wants_Phi = static_cast<bool>(out.phi);
  const Answer answer = ask(in, x.data(), in.memory.data(), wants_Phi, true);
  if (!answer.result) return answer.result;
  if (wants_Phi && answer.Phi.is_none())
    differentiate(in, x, before.data(), answer, out);
  else if (wants_Phi)
    write_Phi(answer, out);
  if (out.Qd) write_Qd(answer, out);
  for (std::size_t i = 0; i < advanced_.size(); ++i) std::ranges::copy(answer.x[i], out.x[advanced_[i]].data());
  return Result::ok();
}

/// Fails for a block that the model gives and did not declare.
void PythonProcess::refuse_others(const py::dict& blocks, std::size_t found, const char* what, const char* how) const {
  if (found == blocks.size()) return;
  throw py::key_error(std::string(what) + " has blocks " + py::str(py::list(blocks)).cast<std::string>() +
                      ", and some are not declared: binding." + how + "(\"to\", \"from\") in __init__");
}

void PythonProcess::write_Phi(const Answer& answer, ProcessOutput& out) const {
  const py::dict blocks = dict_of(answer.Phi, "Phi");
  std::size_t found = 0;
  for (const Block& block : transition_) {
    const BlockView to = out.phi[block.phi];
    const py::tuple key = key_of(block);
    if (!to) continue;
    if (blocks.contains(key)) {
      ++found;
      copy_matrix(blocks[key], "Phi of " + text_of(key), to.rows(), to.cols(), to.data(), to.rows());
    } else if (block.to == block.from) {
      to.set_identity();
    } else {
      to.set_zero();
    }
  }
  refuse_others(blocks, found, "Phi", "couples");
}

void PythonProcess::write_Qd(const Answer& answer, ProcessOutput& out) const {
  const py::dict blocks = dict_of(answer.Qd, "Qd");
  std::size_t found = 0;
  for (const Block& block : noise_) {
    const BlockView to = out.Qd[block.q];
    const py::tuple key = key_of(block);
    if (!to) continue;
    const std::string what = "Qd of " + text_of(key);
    if (!blocks.contains(key)) {
      to.set_zero();
      continue;
    }
    ++found;
    if (block.to == block.from)
      copy_covariance(blocks[key], what, to.rows(), to.data(), to.rows());
    else
      copy_matrix(blocks[key], what, to.rows(), to.cols(), to.data(), to.rows());
  }
  refuse_others(blocks, found, "Qd", "adds_noise");
}

py::tuple PythonProcess::key_of(const Block& block) const {
  return py::make_tuple(model().spec.ports[as_size(block.to.index())].name,
                        model().spec.ports[as_size(block.from.index())].name);
}

/// Φ = ∂(x⁺(x ⊞ δ) ⊟ x⁺(x))/∂δ by central differences at a step and at half of it (Richardson).
void PythonProcess::differentiate(const ProcessInput& in, const std::vector<const double*>& x, const std::byte* before,
                                  const Answer& nominal, ProcessOutput& out) const {
  for (const Port from : ports_) {
    std::vector<const Block*> blocks;
    for (const Block& block : transition_)
      if (block.from.index() == from.index() && out.phi[block.phi]) blocks.push_back(&block);
    if (in.step.dt != 0) {
      differentiate_by(from, blocks, in, x, before, nominal, out);
      continue;
    }
    for (const Block* block : blocks) {
      out.phi[block->phi].set_zero();
      if (block->to == block->from) out.phi[block->phi].set_identity();
    }
  }
}

/// All blocks of one column of blocks: the model is asked once for each value of the port that they depend on.
void PythonProcess::differentiate_by(Port from, const std::vector<const Block*>& blocks, const ProcessInput& in,
                                     const std::vector<const double*>& x, const std::byte* before,
                                     const Answer& nominal, ProcessOutput& out) const {
  if (blocks.empty()) return;
  const std::size_t bytes = layout().words() * sizeof(std::uint64_t);
  const double* const nominal_from = x[as_size(from.index())];
  int rows = 0;
  for (const Block* block : blocks) rows += manifold_of(block->to).dof();
  std::vector<double> moved(as_size(manifold_of(from).stored_size()));
  const auto value_at = [&](int component, double size) {
    manifold_of(from).move(nominal_from, component, size, moved.data());
    auto at = x;
    at[as_size(from.index())] = moved.data();
    std::vector<std::byte> memory(before, before + bytes);
    const Answer answer = ask(in, at.data(), memory.data(), false, false);
    if (!answer.result)
      throw py::value_error(std::string("Phi is made of differences, and at a state near by the model refuses: ") +
                            answer.result.reason);
    Eigen::VectorXd delta(rows);
    double* part = delta.data();
    for (const Block* block : blocks) {
      const auto advanced = static_cast<std::size_t>(std::ranges::find(advanced_, block->to) - advanced_.begin());
      manifold_of(block->to).minus(answer.x[advanced].data(), nominal.x[advanced].data(), part);
      part += manifold_of(block->to).dof();
    }
    return delta;
  };
  for (int j = 0; j < manifold_of(from).dof(); ++j) {
    const Eigen::VectorXd column =
        by_differences([&](double delta) { return value_at(j, delta); }, step_of(from, nominal_from, j));
    const double* part = column.data();
    for (const Block* block : blocks) {
      const BlockView to = out.phi[block->phi];
      std::copy_n(part, to.rows(), to.data() + j * to.rows());
      part += to.rows();
    }
  }
}

}  // namespace binnacle::python
