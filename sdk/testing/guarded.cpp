// SPDX-License-Identifier: Apache-2.0
#include "guarded.hpp"

#include <algorithm>
#include <cmath>

namespace binnacle::testing {

namespace {

constexpr double canary = 8.251e77;
CallObserver* current_observer = nullptr;

}  // namespace

double unwritten() { return std::bit_cast<double>(std::uint64_t{0x7ff8'b1a0'0000'c1e5}); }

Guarded::Guarded(std::size_t size, double fill) : values_(size + 2 * margin, fill), fill_(fill) {
  for (std::size_t i = 0; i < margin; ++i) values_[i] = values_[values_.size() - 1 - i] = canary;
}
bool Guarded::is_intact() const {
  for (std::size_t i = 0; i < margin; ++i)
    if (!same_bits(values_[i], canary) || !same_bits(values_[values_.size() - 1 - i], canary)) return false;
  return true;
}
bool Guarded::has_unwritten() const {
  return std::any_of(data(), data() + size(), [&](double v) { return same_bits(v, fill_); });
}

void examine(const Guarded& block, const std::string& what, double fill, std::string& damage) {
  if (!damage.empty()) return;
  if (!block.is_intact())
    damage = what + ": written beyond its end";
  else if (std::isnan(fill) && block.has_unwritten())
    damage = what + ": not written completely";
}

const double* Inputs::keep(std::string name, const double* values, std::size_t count) {
  if (!values) return nullptr;
  Kept& kept = all_.emplace_back(Kept{std::move(name), {values, values + count}, Guarded(count, 0.0)});
  std::copy(values, values + count, kept.copy.data());
  return kept.copy.data();
}

std::string Inputs::damage(const char* call) const {
  for (const auto& kept : all_)
    if (!kept.copy.is_intact() || !std::equal(kept.original.begin(), kept.original.end(), kept.copy.data(), same_bits))
      return std::string(call) + "() writes to " + kept.name + ", which is an input";
  return "";
}

std::vector<const double*> pointers(const PortStates& ports, const ComponentSpec* spec, Inputs& inputs) {
  const auto name_of = [&](std::size_t i) {
    return "x of port " + (spec ? "'" + spec->ports.at(i).name + "'" : std::to_string(i));
  };
  std::vector<const double*> x;
  for (std::size_t i = 0; i < ports.size(); ++i)
    x.push_back(ports[i].is_open() ? nullptr : inputs.keep(name_of(i), ports[i].x));
  return x;
}

SampleView guarded_sample(const SampleView& sample, const std::vector<FieldSpec>& fields, const std::string& name,
                          Inputs& inputs) {
  const auto per_row =
      static_cast<std::size_t>(std::count_if(fields.begin(), fields.end(), [](const auto& f) { return f.is_per_row; }));
  SampleView copy = sample;
  copy.fields = inputs.keep(name, sample.fields, fields.size() - per_row);
  copy.row_fields = inputs.keep(name + " (its rows)", sample.row_fields, as_size(sample.rows) * per_row);
  return copy;
}

std::vector<SampleView> guarded_inputs(std::span<const SampleView> given, const ComponentSpec& spec, Inputs& inputs) {
  std::vector<SampleView> all(spec.inputs.size());
  for (std::size_t i = 0; i < std::min(all.size(), given.size()); ++i)
    all[i] = guarded_sample(given[i], spec.inputs[i].fields, "the sample on '" + spec.inputs[i].name + "'", inputs);
  return all;
}

void observe_calls(CallObserver* observer) { current_observer = observer; }
CallObserver* call_observer() { return current_observer; }

}  // namespace binnacle::testing
