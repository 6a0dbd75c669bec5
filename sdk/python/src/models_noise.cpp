// SPDX-License-Identifier: Apache-2.0
#include "models_adapters.hpp"
#include "models_spec.hpp"

namespace binnacle::python {

namespace {

const char* name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::accepted: return "accepted";
    case Outcome::gated: return "gated";
    case Outcome::late: return "late";
    case Outcome::unsupported: return "unsupported";
    case Outcome::invalid: return "invalid";
    case Outcome::withheld: return "withheld";
    case Outcome::rejected: return "rejected";
  }
  return "";
}

py::array_t<double> array_of(ConstVectorView v) {
  return sealed(copy_of(v.data(), static_cast<py::ssize_t>(v.size())));
}
py::array_t<double> array_of(ConstMatrixView m) { return sealed(copy_of(m.data, m.rows, m.cols, m.stride)); }

template <class T>
py::tuple tuple_of(std::span<const T> numbers) {
  py::tuple tuple(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) tuple[i] = numbers[i];
  return tuple;
}

}  // namespace

PythonNoise::PythonNoise(const ModelClass& model, const Binding& binding, const NoiseBinding& noise)
    : PythonModel(model, binding, &noise) {
  in_python([&] {
    declaration_.keeps_array<std::uint64_t>(layout().words());
    estimate_ = method("estimate");
    if (py::hasattr(model.type.get(), "after")) {
      after_ = method("after");
      declaration_.wants_after();
    }
    if (declared().is_judged_by_nominal) declaration_.judged_by_nominal();
  });
}

void PythonNoise::initialise(const MemoryView& memory) const { layout().write_initial(memory.data()); }

void PythonNoise::estimate(const Innovation& in, MatrixView R) const {
  in_python([&] {
    py::dict memory = layout().read(in.memory.data()), extras;
    py::list notes;
    if (estimate_.takes("memory")) extras["memory"] = memory;
    if (estimate_.takes("notes")) extras["notes"] = notes;
    const py::object innovation =
        names_.innovation.get()(in.t, in.dt, tuple_of(in.row_keys), tuple_of(in.row_groups), array_of(in.residual),
                                array_of(in.HPHt), array_of(in.R_nominal));
    const py::object answer = estimate_(extras, innovation);
    layout().write(memory, in.memory.data());
    leave(in.notes, notes);
    copy_covariance(answer, "R", in.rows, R.data, R.stride);
  });
}

void PythonNoise::after(const AfterUpdate& in) const {
  in_python([&] {
    py::dict memory = layout().read(in.memory.data()), extras;
    if (after_.takes("memory")) extras["memory"] = memory;
    after_(extras, names_.update.get()(name_of(in.outcome), array_of(in.residual), array_of(in.HPHt)));
    layout().write(memory, in.memory.data());
  });
}

}  // namespace binnacle::python
