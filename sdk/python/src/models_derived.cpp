// SPDX-License-Identifier: Apache-2.0
#include "models_adapters.hpp"
#include "models_spec.hpp"
#include "wording/wording.hpp"

namespace binnacle::python {

using wording::as_size;

struct PythonDerived::Answer {
  Result result;
  std::vector<double> value;
  py::object J;
};

PythonDerived::PythonDerived(const ModelClass& model, const Binding& binding) : PythonModel(model, binding) {
  in_python([&] {
    const auto& yields = declared().yields;
    if (!yields)
      throw py::value_error(
          "the model does not say what it yields: binding.yields_like(\"port\"), or binding.yields(…)");
    declaration_.yields_like(*yields);
    add_manifold(*yields);
    reads_ = read_ports();
    for (const Port port : reads_) declaration_.reads(port);
    evaluate_ = method("evaluate");
  });
}

Result PythonDerived::evaluate(const DerivedInput& in, DerivedOutput& out) const {
  return in_python([&] { return evaluate_in_python(in, out); });
}

PythonDerived::Answer PythonDerived::ask(const DerivedInput& in, const double* const* x, bool wants_J,
                                         bool leaves_notes) const {
  py::dict extras;
  py::list notes;
  if (evaluate_.takes("u")) extras["u"] = to_python(names_, in.u, model().spec.driving_rates);
  if (evaluate_.takes("notes")) extras["notes"] = notes;
  if (evaluate_.takes("wants_J")) extras["wants_J"] = wants_J;
  const py::object answer = evaluate_(extras, values(x));
  if (leaves_notes) leave(in.notes, notes);
  if (const auto refused = refusal_of(names_, answer)) return {*refused, {}, {}};
  if (!py::isinstance<py::tuple>(answer) || py::len(answer) != 2)
    throw py::type_error("evaluate gives " + py::repr(answer).cast<std::string>() +
                         "; it gives (value, J), or a refusal such as binnacle.unsupported(\"why\")");
  const auto parts = py::reinterpret_borrow<py::tuple>(answer);
  Answer made{Result::ok(), std::vector<double>(as_size(declaration_.stored_size)), parts[1]};
  copy_vector(parts[0], "the value", declaration_.stored_size, made.value.data());
  return made;
}

Result PythonDerived::evaluate_in_python(const DerivedInput& in, DerivedOutput& out) const {
  std::vector<const double*> x;
  for (const Port port : ports_) x.push_back(in.x[port].data());
  const bool wants_J = static_cast<bool>(out.J);
  const Answer answer = ask(in, x.data(), wants_J, true);
  if (!answer.result) return answer.result;
  std::copy(answer.value.begin(), answer.value.end(), out.value.data());
  if (!wants_J) return Result::ok();
  if (answer.J.is_none()) return differentiate(in, x, answer, out);
  if (!py::isinstance<py::dict>(answer.J) || py::len(answer.J) != reads_.size())
    throw py::type_error("J is " + py::repr(answer.J).cast<std::string>() +
                         "; it is a dict with the Jacobian of each port that is read, or None");
  const auto J = py::reinterpret_borrow<py::dict>(answer.J);
  for (const Port read : reads_) {
    const std::string& name = model().spec.ports[as_size(read.index())].name;
    const MatrixView to = out.J[read];
    copy_matrix(J[name.c_str()], "J of '" + name + "'", declaration_.dof(), read.dof(), to.data, to.stride);
  }
  return Result::ok();
}

/// J = ∂(g(x ⊞ δ) ⊟ g(x))/∂δ by central differences at a step and at half of it (Richardson).
Result PythonDerived::differentiate(const DerivedInput& in, const std::vector<const double*>& x, const Answer& nominal,
                                    DerivedOutput& out) const {
  const Manifold& yields = manifolds().back();
  if (!yields.is_known())
    throw py::value_error("nothing says what differences of its value are (kind '" + yields.kind() +
                          "'): the model has to give J");
  Result refused = Result::ok();
  for (const Port read : reads_) {
    const double* const from = x[as_size(read.index())];
    std::vector<double> moved(as_size(read.stored_size()));
    const auto value_at = [&](int component, double size) {
      Eigen::VectorXd delta = Eigen::VectorXd::Zero(yields.dof());
      manifold_of(read).move(from, component, size, moved.data());
      auto at = x;
      at[as_size(read.index())] = moved.data();
      const Answer answer = ask(in, at.data(), false, false);
      if (answer.result)
        yields.minus(answer.value.data(), nominal.value.data(), delta.data());
      else
        refused = answer.result;
      return delta;
    };
    const MatrixView to = out.J[read];
    for (int j = 0; j < read.dof() && refused; ++j) {
      const Eigen::VectorXd column =
          by_differences([&](double delta) { return value_at(j, delta); }, step_of(read, from, j));
      for (int i = 0; i < yields.dof(); ++i) to(i, j) = column[i];
    }
  }
  return refused;
}

}  // namespace binnacle::python
