// SPDX-License-Identifier: Apache-2.0
// What a component learns when it is bound into a composition: its parameters and what its ports are plugged into.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/handle.hpp"
#include "binnacle/parameters.hpp"
#include "binnacle/spec.hpp"

namespace binnacle {

struct ChannelDeclaration;

/// One error component of a block, one output, one row of a residual: a name and its SI unit.
struct NamedUnit {
  std::string name;
  std::string unit;
};

/// What a component found out while it was bound: figures for `binnacle explain`, and what is suspicious but no error.
struct Findings {
  /// A number that `binnacle explain` shows.
  struct Figure {
    std::string name;
    double value = 0;  // SI
    std::string unit;
  };
  std::vector<Figure> figures;
  std::vector<std::string> notes;  // each a warning (B032) at the component
};

/// A port of this component, in the order of its spec.
struct PortBinding {
  std::string name;
  bool bound = false;                 // false: an optional port left open; its pointers are null at run time
  std::string kind;                   // of the block plugged in, "vector:3:rad/s"
  int dof = 0;                        // error dimension, all components counted
  int stored_size = 0;                // doubles in its stored value
  std::vector<NamedUnit> components;  // error components
  /// False: all of them are frozen, so nobody reads the blocks of Φ and Qd with its rows or columns. propagate() may leave
  /// them as they are; F and GQGᵀ are wanted whole.
  bool is_estimated = true;
};

/// What the kernel makes a Binding of.
struct BindingParts {
  std::string name;
  Parameters parameters;
  std::vector<PortBinding> ports = {};
  std::vector<bool> fields_bound = {};  // the component's own, then those of its inputs
  int samples_per_step = 1;
  std::vector<std::vector<NamedUnit>> covariances = std::vector<std::vector<NamedUnit>>(1);  // by input
  const ComponentSpec* spec = nullptr;  // has the names of fields, inputs and driving rates
  std::vector<bool> inputs_bound = {};
  std::vector<const ChannelDeclaration*> channels = {};  // by input, of transforms and sinks; null: open
  bool has_driving_rates = false;
  Findings* findings = nullptr;  // null: figures and notes go nowhere
};

/// Handed to a component's constructor, which keeps what it needs; references into it die with the call, handles do not.
class Binding {
 public:
  explicit Binding(BindingParts parts) : parts_(std::move(parts)) {}

  /// The JSON key under which the component stands.
  const std::string& name() const noexcept { return parts_.name; }
  const Parameters& parameters() const noexcept { return parts_.parameters; }
  const std::vector<PortBinding>& ports() const noexcept { return parts_.ports; }
  /// Handle of a port; throws std::logic_error for a name that the spec does not declare, as do all that follow.
  Port port(std::string_view name) const {
    const std::size_t i = index_of(parts_.ports, "port", name);
    const PortBinding& block = parts_.ports[i];
    return block.bound ? Port(static_cast<int>(i), block.dof, block.stored_size) : Port(static_cast<int>(i), 0, 0);
  }
  /// What is plugged in: kind and names of its components.
  const PortBinding& block(std::string_view name) const { return parts_.ports[index_of(parts_.ports, "port", name)]; }

  /// Handle of a field with one value per sample (ComponentSpec::fields).
  Field field(std::string_view name) const { return epoch_field(spec().fields, 0, name); }
  /// Of a field on a channel of ComponentSpec::inputs.
  Field field(Input input, std::string_view name) const {
    return epoch_field(fields_of(input), first_field_of(input), name);
  }
  /// Handles of several that are read as one vector: `binding.fields("vn", "ve", "vd")`, `binding.fields(imu, "wx", …)`.
  template <class... Names>
  Fields<static_cast<int>(sizeof...(Names))> fields(const Names&... names) const {
    return {{field(std::string_view(names))...}};
  }
  template <class... Names>
  Fields<static_cast<int>(sizeof...(Names))> fields(Input input, const Names&... names) const {
    return {{field(input, std::string_view(names))...}};
  }
  /// Handle of a field with one value per row.
  RowField row_field(std::string_view name) const { return find(spec().fields, 0, name, true); }
  RowField row_field(Input input, std::string_view name) const {
    return find(fields_of(input), first_field_of(input), name, true);
  }
  /// Handle of a channel of ComponentSpec::inputs.
  Input input(std::string_view name) const {
    const std::size_t i = index_of(spec().inputs, "input", name);
    return Input(static_cast<int>(i), i < parts_.inputs_bound.size() && parts_.inputs_bound[i]);
  }
  /// Handle of a driving rate (ComponentSpec::driving_rates).
  DrivingRate driving_rate(std::string_view name) const {
    return DrivingRate(static_cast<int>(index_of(spec().driving_rates, "driving rate", name)),
                       parts_.has_driving_rates);
  }
  template <class... Names>
  DrivingRateVector<static_cast<int>(sizeof...(Names))> driving_rates(const Names&... names) const {
    return {{driving_rate(std::string_view(names))...}};
  }
  /// The error components of SampleView::covariance, of a measurement's channel or of a transform's input. Empty where
  /// the channel attaches none. A filter's channel calls them BLOCK.COMPONENT.
  const std::vector<NamedUnit>& covariance() const { return parts_.covariances.at(0); }
  const std::vector<NamedUnit>& covariance(Input input) const {
    return parts_.covariances.at(static_cast<std::size_t>(input.index()));
  }
  /// What the channel on a whole input declares (ChannelPort::whole()).
  const ChannelDeclaration& channel(Input input) const {
    const auto i = static_cast<std::size_t>(input.index());
    if (i >= parts_.channels.size() || !parts_.channels[i]) throw std::logic_error("no channel is on this input");
    return *parts_.channels[i];
  }
  /// Process model: the samples that a step hands it unless a measurement cuts the group short. A filter's steps are
  /// those of its process model that asks for most.
  int samples_per_step() const noexcept { return parts_.samples_per_step; }

  /// A figure that the component found out itself, in SI, for people: what a fit came to. `binnacle explain` shows it.
  void figure(std::string name, double value, std::string unit) const {
    if (parts_.findings) parts_.findings->figures.push_back({std::move(name), value, std::move(unit)});
  }
  /// Something suspicious that is no error, one line: a poor fit. It becomes a warning at the component.
  void note(std::string message) const {
    if (parts_.findings) parts_.findings->notes.push_back(std::move(message));
  }

 private:
  template <class Named>
  static std::size_t index_of(const std::vector<Named>& all, const char* what, std::string_view name) {
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].name == name) return i;
    throw std::logic_error(std::string(what) + " '" + std::string(name) + "' is not declared in the spec");
  }
  const ComponentSpec& spec() const {
    if (!parts_.spec) throw std::logic_error("this binding knows no spec");
    return *parts_.spec;
  }
  const std::vector<FieldSpec>& fields_of(Input input) const {
    return spec().inputs.at(static_cast<std::size_t>(input.index())).fields;
  }
  /// Of an input's fields in fields_bound, where they follow the component's own.
  std::size_t first_field_of(Input input) const {
    std::size_t first = spec().fields.size();
    for (int i = 0; i < input.index(); ++i) first += spec().inputs[static_cast<std::size_t>(i)].fields.size();
    return first;
  }
  /// Among the declared fields that are per row, or those that are not; `first`: where the first is in fields_bound.
  RowField find(const std::vector<FieldSpec>& declared, std::size_t first, std::string_view name,
                bool is_per_row) const {
    int index = -1, width = 0;
    bool is_there = false;
    for (std::size_t i = 0; i < declared.size(); ++i) {
      if (declared[i].is_per_row != is_per_row) continue;
      if (declared[i].name == name)
        index = width, is_there = first + i < parts_.fields_bound.size() && parts_.fields_bound[first + i];
      ++width;
    }
    if (index < 0)
      throw std::logic_error("field '" + std::string(name) + "' is not declared in the spec as one value per " +
                             (is_per_row ? "row" : "sample"));
    return RowField(index, width, is_there);
  }
  Field epoch_field(const std::vector<FieldSpec>& declared, std::size_t first, std::string_view name) const {
    const RowField found = find(declared, first, name, false);
    return Field(found.index(), found.is_bound());
  }

  BindingParts parts_;
};

}  // namespace binnacle
