// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iterator>

#include "models_adapters.hpp"
#include "models_spec.hpp"
#include "wording/wording.hpp"

namespace binnacle::python {

// ---- what all roles have in common

using wording::as_size;

PythonModel::PythonModel(const ModelClass& model, const Binding& binding, const NoiseBinding* noise) {
  in_python([&] {
    declared_ = std::make_shared<ModelBinding>(binding, model, noise);
    object_ = Held(model.type.get()(declared_));
    declared_->close();
    py::module_::import("binnacle._models").attr("bound")(object_.get());
    for (const auto& port : model.spec.ports) {
      ports_.push_back(binding.port(port.name));
      port_names_.emplace_back(py::str(port.name));
      add_manifold(binding.block(port.name));
    }
  });
}

Method PythonModel::method(const char* name) const {
  return Method(object_.get(), name, py::reinterpret_borrow<py::dict>(model().extras.get()));
}

Port PythonModel::port(const std::string& name) const {
  for (std::size_t i = 0; i < ports_.size(); ++i)
    if (model().spec.ports[i].name == name) return ports_[i];
  throw py::key_error("the spec has no port '" + name + "'");
}

std::vector<Port> PythonModel::read_ports() const {
  std::vector<Port> read;
  const auto& reads = declared_->reads;
  for (std::size_t i = 0; i < ports_.size(); ++i)
    if (ports_[i].is_bound() && (!reads || std::ranges::find(*reads, model().spec.ports[i].name) != reads->end()))
      read.push_back(ports_[i]);
  return read;
}

const Manifold& PythonModel::manifold_of(Port port) const {
  const Manifold& manifold = manifolds()[as_size(port.index())];
  if (manifold.is_known()) return manifold;
  throw py::value_error("nothing says what differences on port '" + model().spec.ports[as_size(port.index())].name +
                        "' are (kind '" + manifold.kind() + "'): the model has to give the Jacobian itself");
}

double PythonModel::step_of(Port port, const double* x, int component) const {
  const auto given = declared().steps.find(model().spec.ports[as_size(port.index())].name);
  return given != declared().steps.end() ? given->second : manifold_of(port).step(x, component);
}

py::dict PythonModel::values(const double* const* by_port) const {
  py::dict dict;
  for (std::size_t i = 0; i < ports_.size(); ++i)
    dict[port_names_[i].get()] = ports_[i].is_bound() && by_port[i]
                                     ? py::object(sealed(copy_of(by_port[i], ports_[i].stored_size())))
                                     : py::object(py::none());
  return dict;
}

// ---- measurement models

struct PythonMeasurement::Answer {
  Result result;
  Eigen::VectorXd residual;
  py::object H, R;
  std::vector<std::int64_t> keys;  // empty: 0, 1, 2 …
};

PythonMeasurement::PythonMeasurement(const ModelClass& model, const Binding& binding) : PythonModel(model, binding) {
  in_python([&] {
    sample_ = SampleNames(model.spec.fields);
    for (const auto& input : model.spec.inputs) inputs_.emplace_back(input.fields);
    covariance_dof_ = static_cast<int>(binding.covariance().size());
    reads_ = read_ports();
    declare();
    std::vector<Port> bound;
    std::ranges::copy_if(ports_, std::back_inserter(bound), [](Port port) { return port.is_bound(); });
    fast_ = fast_measurement(declared(), bound, reads_, declaration_.max_rows);
    if (fast_) return;
    linearize_ = method("linearize");
    declaration_.differentiated_by(Differentiation::by_hand);
  });
}

void PythonMeasurement::declare() {
  int rows = 0;
  for (const auto& group : declared().groups) {
    if (group.port)
      declaration_.group(rows::of(group.name, port(*group.port)));
    else
      declaration_.group(group.rows > 0 ? rows::these(group.name, group.rows, group.unit)
                                        : rows::like(group.name, group.unit));
    rows += declaration_.groups.back().rows;
  }
  if (declared().rows > 0) rows = declared().rows;
  if (rows < 1)
    throw py::value_error(
        "the model declares no rows: binding.rows(1), or binding.group(\"range\", rows=1, unit=\"m\")");
  declaration_.rows(rows);
  for (const Port port : reads_) declaration_.reads(port);
  if (declared().wants_covariance) declaration_.wants_covariance();
  declaration_.keeps_array<std::uint64_t>(layout().words());
}

void PythonMeasurement::initialise(const MemoryView& memory) const { layout().write_initial(memory.data()); }

Result PythonMeasurement::linearize(const MeasurementInput& in, MeasurementOutput& out) const {
  if (fast_) return fast_->linearize(in, out);
  return in_python([&] { return linearize_in_python(in, out); });
}

py::dict PythonMeasurement::extras(const MeasurementInput& in, py::dict& memory, py::list& notes, bool wants_H) const {
  py::dict extras;
  if (linearize_.takes("memory")) extras["memory"] = memory;
  if (linearize_.takes("notes")) extras["notes"] = notes;
  if (linearize_.takes("wants_H")) extras["wants_H"] = wants_H;
  if (linearize_.takes("u")) extras["u"] = to_python(names_, in.u, model().spec.driving_rates);
  if (linearize_.takes("auxiliary")) extras["auxiliary"] = to_python(names_, in.auxiliary, model().spec, inputs_);
  if (linearize_.takes("P")) extras["P"] = to_python(in.P, reads_, model().spec);
  return extras;
}

/// One call with the state at x. What the model remembers goes to `memory`.
PythonMeasurement::Answer PythonMeasurement::ask(const MeasurementInput& in, const double* const* x, std::byte* memory,
                                                 bool wants_H, bool leaves_notes) const {
  py::dict kept = layout().read(memory);
  py::list notes;
  const py::object answer =
      linearize_(extras(in, kept, notes, wants_H), sample_(names_, in.sample, covariance_dof_), values(x));
  layout().write(kept, memory);
  if (leaves_notes) leave(in.notes, notes);
  if (const auto refused = refusal_of(names_, answer)) return {*refused, {}, {}, {}, {}};
  const bool is_tuple = py::isinstance<py::tuple>(answer);
  const auto parts = is_tuple ? py::reinterpret_borrow<py::tuple>(answer) : py::tuple();
  if (parts.size() != 3 && parts.size() != 4)
    throw py::type_error("linearize gives " + py::repr(answer).cast<std::string>() +
                         "; it gives (residual, H, R), (residual, H, R, keys), or a refusal such as "
                         "binnacle.unsupported(\"why\")");
  const ReturnedNumbers residual = numbers_of(parts[0], "the residual");
  if (residual.ndim() > 1 || residual.size() > declaration_.max_rows)
    throw py::value_error("the residual is of shape " + py::str(residual.attr("shape")).cast<std::string>() +
                          "; the model declares at most " + std::to_string(declaration_.max_rows) + " rows");
  Answer made{Result::ok(), Eigen::VectorXd(residual.size()), parts[1], parts[2], {}};
  copy_vector(residual, "the residual", static_cast<int>(residual.size()), made.residual.data());
  if (parts.size() == 4) {
    for (const auto& key : parts[3])
      made.keys.push_back(py::int_(py::reinterpret_borrow<py::object>(key)).cast<std::int64_t>());
    if (made.keys.size() != static_cast<std::size_t>(residual.size()))
      throw py::value_error("linearize gives " + std::to_string(made.keys.size()) + " keys for " +
                            std::to_string(residual.size()) + " rows");
  }
  return made;
}

Result PythonMeasurement::linearize_in_python(const MeasurementInput& in, MeasurementOutput& out) const {
  const std::size_t bytes = layout().words() * sizeof(std::uint64_t);
  const std::vector<std::byte> before(in.memory.data(), in.memory.data() + bytes);
  std::vector<const double*> x;
  for (const Port port : ports_) x.push_back(in.x[port].data());
  const bool wants_H = static_cast<bool>(out.H);
  const Answer answer = ask(in, x.data(), in.memory.data(), wants_H, true);
  if (!answer.result) return answer.result;
  out.rows = static_cast<int>(answer.residual.size());
  std::copy_n(answer.residual.data(), out.rows, out.residual.data());
  std::ranges::copy(answer.keys, out.row_keys.begin());
  copy_covariance(answer.R, "R", out.rows, out.R.data, out.R.stride);
  if (!wants_H || out.rows == 0) return Result::ok();
  return answer.H.is_none() ? differentiate(in, before.data(), answer, out) : write_H(answer, out);
}

Result PythonMeasurement::write_H(const Answer& answer, MeasurementOutput& out) const {
  if (!py::isinstance<py::dict>(answer.H))
    throw py::type_error("H is " + py::repr(answer.H).cast<std::string>() +
                         "; it is a dict of Jacobians by port, or None to have it made of differences");
  const auto H = py::reinterpret_borrow<py::dict>(answer.H);
  std::size_t found = 0;
  for (const Port read : reads_) {
    const std::string& name = model().spec.ports[as_size(read.index())].name;
    const MatrixView to = out.H[read];
    if (!H.contains(name.c_str()))
      throw py::key_error("H has no block of port '" + name +
                          "', which the model reads; where it has none, declare "
                          "the others: binding.reads(…)");
    ++found;
    copy_matrix(H[name.c_str()], "H of '" + name + "'", out.rows, read.dof(), to.data, to.stride);
  }
  if (found != H.size())
    throw py::key_error("H has blocks of " + py::str(py::list(H)).cast<std::string>() +
                        ": more than the ports that are bound and that the model reads");
  return Result::ok();
}

/// H = −∂r/∂δ by central differences at a step and at half of it (Richardson), as jacobian.hpp takes them.
Result PythonMeasurement::differentiate(const MeasurementInput& in, const std::byte* before, const Answer& nominal,
                                        MeasurementOutput& out) const {
  std::vector<const double*> x;
  for (const Port port : ports_) x.push_back(in.x[port].data());
  const std::size_t bytes = layout().words() * sizeof(std::uint64_t);
  Result refused = Result::ok();
  for (const Port read : reads_) {
    const Manifold& manifold = manifold_of(read);
    std::vector<double> moved(as_size(manifold.stored_size()));
    const auto residual_at = [&](int component, double size) {
      manifold.move(in.x[read].data(), component, size, moved.data());
      auto at = x;
      at[as_size(read.index())] = moved.data();
      std::vector<std::byte> memory(before, before + bytes);
      const Answer answer = ask(in, at.data(), memory.data(), false, false);
      if (!answer.result || answer.residual.size() != nominal.residual.size() || answer.keys != nominal.keys) {
        refused = Result::unsupported("its Jacobian is made of differences, and a state near by has other rows");
        return nominal.residual;
      }
      return answer.residual;
    };
    const MatrixView to = out.H[read];
    for (int j = 0; j < read.dof() && refused; ++j) {
      // H is of the prediction, the opposite of the residual.
      const Eigen::VectorXd column =
          by_differences([&](double delta) { return residual_at(j, -delta); }, step_of(read, in.x[read].data(), j));
      for (int i = 0; i < out.rows; ++i) to(i, j) = column[i];
    }
  }
  return refused;
}

}  // namespace binnacle::python
