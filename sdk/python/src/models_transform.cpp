// SPDX-License-Identifier: Apache-2.0
#include "models_adapters.hpp"
#include "models_spec.hpp"
#include "wording/wording.hpp"

namespace binnacle::python {

namespace {

using wording::as_size;

std::string listed(const py::dict& dict) { return py::str(py::list(dict)).cast<std::string>(); }

}  // namespace

PythonTransform::PythonTransform(const ModelClass& model, const Binding& binding) : PythonModel(model, binding) {
  in_python([&] {
    for (const auto& input : model.spec.inputs) {
      inputs_.emplace_back(input.fields);
      covariance_dof_.push_back(static_cast<int>(binding.covariance(binding.input(input.name)).size()));
    }
    if (declared().channels.empty())
      throw py::value_error("the model declares no channel: binding.emits(\"\", [field(\"speed\", \"m/s\")])");
    for (const auto& channel : declared().channels) declaration_.emits(channel);
    declaration_.keeps_array<std::uint64_t>(layout().words());
    emission_ = Held(py::module_::import("binnacle._models").attr("Emission"));
    on_ = method("on");
  });
}

void PythonTransform::initialise(std::uint64_t, const MemoryView& memory) const {
  layout().write_initial(memory.data());
}

void PythonTransform::on(const TransformInput& in, Emitter& out) const {
  in_python([&] {
    py::dict memory = layout().read(in.memory.data()), extras;
    if (on_.takes("memory")) extras["memory"] = memory;
    if (on_.takes("input")) extras["input"] = model().spec.inputs[as_size(in.from.index())].name;
    const std::size_t input = as_size(in.from.index());
    const py::object emission = emission_.get()();
    on_(extras, inputs_[input](names_, in.sample, covariance_dof_[input]), emission);
    layout().write(memory, in.memory.data());
    std::vector<bool> has_emitted(declaration_.channels.size(), false);
    for (const auto& emitted : py::list(emission.attr("samples"))) emit(emitted, in.sample, out, has_emitted);
  });
}

std::size_t PythonTransform::channel_named(const std::string& name) const {
  for (std::size_t i = 0; i < declaration_.channels.size(); ++i)
    if (declaration_.channels[i].name == name) return i;
  throw py::key_error("the model emits on a channel '" + name + "' that it did not declare: binding.emits(…)");
}

/// emitted: (channel, fields, t, t0, covariance).
void PythonTransform::emit(const py::handle& emitted, const SampleView& from, Emitter& out,
                           std::vector<bool>& has_emitted) const {
  const auto parts = py::reinterpret_borrow<py::tuple>(emitted);
  const auto name = parts[0].cast<std::string>();
  const std::size_t channel = channel_named(name);
  if (has_emitted[channel])
    throw py::value_error("the model emits twice on channel '" + name + "' in one call; it may once");
  has_emitted[channel] = true;
  const OutputChannel handle(static_cast<int>(channel));
  SampleWriter& writer = out.on(handle);
  writer.t = parts[2].is_none() ? from.t : to_time(parts[2], "t");
  writer.t0 = parts[3].is_none() ? from.t0 : to_time(parts[3], "t0");
  write_fields(py::reinterpret_borrow<py::dict>(parts[1]), declaration_.channels[channel], writer);
  if (!parts[4].is_none()) {
    if (writer.covariance_dof == 0) throw py::value_error("channel '" + name + "' is declared without covariance");
    const MatrixView P = writer.attach_covariance();
    copy_covariance(parts[4], "the covariance", P.rows, P.data, P.stride);
  }
  out.emit(handle);
}

void PythonTransform::write_fields(const py::dict& fields, const ChannelDeclaration& channel,
                                   SampleWriter& writer) const {
  std::size_t found = 0;
  int epoch = 0, row_field = 0;
  writer.rows = -1;
  for (const auto& field : channel.fields) {
    const int index = field.is_per_row ? row_field++ : epoch++;
    if (!fields.contains(field.name.c_str())) continue;
    ++found;
    const py::object value = fields[field.name.c_str()];
    if (!field.is_per_row) {
      copy_vector(value, "field '" + field.name + "'", 1, writer.fields + index);
      continue;
    }
    const ReturnedNumbers column = numbers_of(value, "field '" + field.name + "'");
    const auto rows = static_cast<int>(column.size());
    if (column.ndim() != 1 || rows > writer.max_rows || (writer.rows >= 0 && rows != writer.rows))
      throw py::value_error("field '" + field.name + "' is of shape " +
                            py::str(column.attr("shape")).cast<std::string>() +
                            "; fields per row are (rows,), all of the "
                            "same length, of at most " +
                            std::to_string(writer.max_rows));
    writer.rows = rows;
    for (int row = 0; row < rows; ++row) writer.row_view(row)[index] = column.at(row);
  }
  writer.rows = std::max(writer.rows, 0);
  if (found != fields.size())
    throw py::key_error("the model emits fields " + listed(fields) + ", and some are not those of channel '" +
                        channel.name + "'");
}

}  // namespace binnacle::python
