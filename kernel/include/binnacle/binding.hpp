// SPDX-License-Identifier: Apache-2.0
// What a component learns when it is bound into a composition: its parameters and what its ports are plugged into.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "binnacle/parameters.hpp"

namespace binnacle {

/// One error component of a block, one output, one row of a residual: a name and its SI unit.
struct NamedUnit {
  std::string name;
  std::string unit;
};

/// What a component found out while it was bound: figures for `binnacle explain`, and what is suspicious but no error.
struct Findings {
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
};

/// Handed to a component's constructor, which keeps what it needs; references into it die with the call.
class Binding {
 public:
  Binding(std::string name, Parameters parameters, std::vector<PortBinding> ports, std::vector<bool> fields_bound,
          int samples_per_step = 1,
          std::vector<std::vector<NamedUnit>> covariances = std::vector<std::vector<NamedUnit>>(1))
      : name_(std::move(name)),
        parameters_(parameters),
        ports_(std::move(ports)),
        fields_bound_(std::move(fields_bound)),
        covariances_(std::move(covariances)),
        samples_per_step_(samples_per_step) {}

  /// The kernel's: where tell() and note() go; nowhere unless this is called.
  Binding&& telling(Findings& findings) && {
    findings_ = &findings;
    return std::move(*this);
  }

  /// The JSON key under which the component stands.
  const std::string& name() const noexcept { return name_; }
  const Parameters& parameters() const noexcept { return parameters_; }
  const std::vector<PortBinding>& ports() const noexcept { return ports_; }
  int port_index(std::string_view name) const {
    for (std::size_t i = 0; i < ports_.size(); ++i)
      if (ports_[i].name == name) return static_cast<int>(i);
    throw std::logic_error("port '" + std::string(name) + "' is not declared in the spec");
  }
  const PortBinding& block(std::string_view name) const { return ports_[static_cast<std::size_t>(port_index(name))]; }
  bool is_bound(std::string_view port_name) const { return block(port_name).bound; }
  /// Whether the i-th declared field (ComponentSpec::fields) is carried by the channel; required ones always are.
  bool has_field(int i) const { return fields_bound_.at(static_cast<std::size_t>(i)); }
  /// The error components of SampleView::covariance: of a transform's i-th input, of a measurement's channel (0). Empty
  /// where the channel attaches none. A filter's channel calls them BLOCK.COMPONENT.
  const std::vector<NamedUnit>& covariance(int input = 0) const {
    return covariances_.at(static_cast<std::size_t>(input));
  }
  /// Process model: the samples that a step hands it unless a measurement cuts the group short. A filter's steps are
  /// those of its process model that asks for most.
  int samples_per_step() const noexcept { return samples_per_step_; }

  /// A figure that the component found out itself, in SI, for people: what a fit came to. `binnacle explain` shows it.
  void tell(std::string name, double value, std::string unit) const {
    if (findings_) findings_->figures.push_back({std::move(name), value, std::move(unit)});
  }
  /// Something suspicious that is no error, one line: a poor fit. It becomes a warning at the component.
  void note(std::string message) const {
    if (findings_) findings_->notes.push_back(std::move(message));
  }

 private:
  std::string name_;
  Parameters parameters_;
  std::vector<PortBinding> ports_;
  std::vector<bool> fields_bound_;
  std::vector<std::vector<NamedUnit>> covariances_;
  int samples_per_step_;
  Findings* findings_ = nullptr;
};

}  // namespace binnacle
