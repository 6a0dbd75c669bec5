// SPDX-License-Identifier: Apache-2.0
// The faults transform: any channel, spoilt in windows or at random.
#include "faults.hpp"

#include <algorithm>
#include <string>
#include <utility>

namespace binnacle::faults {

ComponentSpec Faults::spec() {
  ComponentSpec spec;
  spec.type = "faults";
  spec.summary =
      "Faults in a channel: steps, ramps, noise, outliers, frozen values, holes, delays and more, in windows or at "
      "random.";
  spec.inputs = {
      input("samples", {field::level("lat", "rad").about("latitude, for example"),
                        field::level("lon", "rad").about("longitude"), field::level("height", "m").about("height")})
          .whole()
          .about("any channel")};
  spec.parameters = {parameter::list("faults", Fault::spec()).required().about("faults, applied in this order")};
  spec.example = R"json({"input": "gnss", "faults": [
      {"kind": "step", "fields": ["lat"], "by": "20 m", "from": "100 s", "until": "130 s"},
      {"kind": "outliers", "fields": ["height"], "size": "50 m", "share": 0.02}, {"kind": "drop", "share": 0.1}]})json";
  spec.surroundings = R"json({"inputs": {"samples": {"lat": 0.85, "lon": 0.15, "height": 120}}})json";
  return spec;
}

Faults::Faults(const Binding& binding) {
  const ChannelDeclaration& channel = binding.channel(binding.input("samples"));
  const auto& elements = binding.parameters().list("faults");
  std::size_t held = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    faults_.emplace_back(elements[i], channel, "/faults/" + std::to_string(i));
    held += faults_.back().held();
  }
  ChannelDeclaration same = channel;
  same.name.clear();
  out_ = declaration_.emits(std::move(same));
  memory_ = declaration_.keeps<Memory>();
  of_fault_ = declaration_.keeps_array<FaultMemory>(faults_.size());
  held_ = declaration_.keeps_array<double>(held);
}

void Faults::initialise(std::uint64_t seed, const MemoryView& memory) const {
  memory[memory_].first = no_time;
  for (std::size_t i = 0; i < faults_.size(); ++i)
    memory[of_fault_][i].random = random::stream(seed, "fault " + std::to_string(i));
}

void Faults::on(const TransformInput& in, Emitter& emitter) const {
  Memory& memory = in.memory[memory_];
  if (memory.first == no_time) memory.first = in.sample.t;
  SampleWriter& out = emitter.on(out_);
  out.t = in.sample.t;
  out.t0 = in.sample.t0;
  out.rows = in.sample.rows;
  std::copy_n(in.sample.fields, out.field_count, out.fields);
  std::copy_n(in.sample.row_fields, out.rows * out.row_width, out.row_fields);
  out.has_covariance = in.sample.covariance != nullptr;
  if (out.has_covariance) std::copy_n(in.sample.covariance, out.covariance_dof * out.covariance_dof, out.covariance);
  Spoilt sample{out, memory.first};
  std::size_t held = 0;
  for (std::size_t i = 0; i < faults_.size(); ++i) {
    faults_[i].apply(sample, in.memory[of_fault_][i], in.memory[held_].data() + held);
    held += faults_[i].held();
  }
  if (sample.is_dropped) return;
  emitter.emit(out_);
  if (sample.is_doubled) emitter.emit_again(out_);
}

}  // namespace binnacle::faults
