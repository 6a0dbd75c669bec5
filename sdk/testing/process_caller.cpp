// SPDX-License-Identifier: Apache-2.0
#include "binnacle/view.hpp"
#include "guarded.hpp"

namespace binnacle::testing {

namespace {

/// Blocks of Φ, F or Q as a model writes them, and as dense matrices.
class Blocks {
 public:
  Blocks(const char* what, const std::vector<Coupling>& couplings, const PortStates& ports, double fill)
      : what_(what), couplings_(couplings), ports_(ports), fill_(fill) {
    for (const auto& c : couplings) {
      const int rows = dof(c.to), columns = dof(c.from);
      blocks_.emplace_back(as_size(c.structure == Structure::diagonal ? rows : rows * columns), fill);
    }
    for (auto& block : blocks_) at_.push_back(block.data());
  }
  double* const* at() const { return at_.data(); }

  void collect(Propagated& out, std::vector<Eigen::MatrixXd>& dense) const {
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (out.result) examine(blocks_[i], std::string(what_) + " " + std::to_string(i), fill_, out.damage);
      const int rows = dof(couplings_[i].to), columns = dof(couplings_[i].from);
      if (couplings_[i].structure == Structure::diagonal)
        dense.push_back(vector_at(blocks_[i].data(), rows).asDiagonal());
      else
        dense.push_back(matrix_at(blocks_[i].data(), rows, columns));
      append(out.numbers, blocks_[i].values());
    }
  }

 private:
  int dof(int port) const { return ports_.at(as_size(port)).dof(); }

  const char* what_;
  const std::vector<Coupling>& couplings_;
  const PortStates& ports_;
  double fill_;
  std::vector<Guarded> blocks_;
  std::vector<double*> at_;
};

/// A step whose samples' fields are guarded copies.
struct GuardedStep {
  GuardedStep(const Step& of, const ComponentSpec& spec, Inputs& inputs) : step(of) {
    for (const auto& sample : of.samples) {
      samples.push_back(sample);
      samples.back().fields = inputs.keep("the step's sample", sample.fields, spec.fields.size());
    }
    step.samples = samples;
  }
  std::vector<InputSample> samples;
  Step step;
};

}  // namespace

std::vector<std::byte> ProcessCaller::fresh_memory() const {
  std::vector<std::byte> memory(declared().memory_bytes);
  called("start", [&] { return model_->start(memory.data()), 0; });
  return memory;
}

Propagated ProcessCaller::propagate(const PortStates& ports, const Step& step, const std::vector<std::byte>& memory,
                                    double fill, bool with_errors) const {
  Propagated out;
  Blocks transition("transition", declared().transition, ports, fill), noise("noise", declared().noise, ports, fill);
  std::vector<Guarded> x_plus;
  std::vector<double*> x_at;
  for (std::size_t i = 0; i < ports.size(); ++i) x_plus.emplace_back(moves(ports, i) ? ports[i].x.size() : 0, fill);
  for (std::size_t i = 0; i < ports.size(); ++i) x_at.push_back(moves(ports, i) ? x_plus[i].data() : nullptr);
  Inputs inputs;
  const auto x = pointers(ports, spec_, inputs);
  const GuardedStep guarded(step, *spec_, inputs);
  out.memory = memory;
  const std::vector<SampleView> auxiliary = guarded_inputs(auxiliary_, *spec_, inputs);
  const ProcessInput input{guarded.step, x.data(), auxiliary.data(), out.memory.data(), {}};
  ProcessOutput output{x_at.data(), {}, {}};
  if (with_errors) output.phi = transition.at(), output.Qd = noise.at();
  out.result = called("propagate", [&] { return model_->propagate(input, output); });

  out.damage = inputs.damage("propagate");
  for (std::size_t i = 0; i < x_plus.size(); ++i) {
    if (out.result) examine(x_plus[i], "x_plus of port " + std::to_string(i), fill, out.damage);
    append(out.numbers, x_plus[i].values());
    out.x_plus.push_back(x_plus[i].values());
  }
  if (with_errors) transition.collect(out, out.transition), noise.collect(out, out.noise);
  if (!out.result) out.numbers.clear();
  return out;
}

Propagated ProcessCaller::linearized(const PortStates& ports, double fill) const {
  Propagated out;
  Blocks dynamics("dynamics", declared().transition, ports, fill), noise("noise", declared().noise, ports, fill);
  Inputs inputs;
  const auto x = pointers(ports, spec_, inputs);
  const std::vector<SampleView> auxiliary = guarded_inputs(auxiliary_, *spec_, inputs);
  ContinuousOutput output{dynamics.at(), noise.at()};
  called("linearized", [&] { return model_->linearized({x.data(), auxiliary.data()}, output), 0; });
  out.damage = inputs.damage("linearized");
  out.x_plus.resize(ports.size());
  dynamics.collect(out, out.transition);
  noise.collect(out, out.noise);
  return out;
}

Eigen::MatrixXd ProcessCaller::whole(const PortStates& ports, const std::vector<Coupling>& couplings,
                                     const std::vector<Eigen::MatrixXd>& blocks, bool identity, bool mirrored) const {
  const int n = offset(ports, ports.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n, n);
  if (identity) all.setIdentity();
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const auto to = as_size(couplings[i].to), from = as_size(couplings[i].from);
    all.block(offset(ports, to), offset(ports, from), ports[to].dof(), ports[from].dof()) = blocks[i];
    if (mirrored && to != from)
      all.block(offset(ports, from), offset(ports, to), ports[from].dof(), ports[to].dof()) = blocks[i].transpose();
  }
  return all;
}

Eigen::MatrixXd ProcessCaller::Phi(const PortStates& ports, const Propagated& p) const {
  return whole(ports, declared().transition, p.transition, true, false);
}
Eigen::MatrixXd ProcessCaller::Q(const PortStates& ports, const Propagated& p) const {
  return whole(ports, declared().noise, p.noise, false, true);
}
Eigen::MatrixXd ProcessCaller::F(const PortStates& ports, const Propagated& continuous) const {
  return whole(ports, declared().transition, continuous.transition, false, false);
}

PortStates ProcessCaller::after(PortStates ports, const Propagated& p) const {
  for (std::size_t i = 0; i < ports.size(); ++i)
    if (moves(ports, i)) ports[i].x = p.x_plus[i];
  return ports;
}

}  // namespace binnacle::testing
