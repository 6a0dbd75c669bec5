// SPDX-License-Identifier: Apache-2.0
// From a document to a CompositionPlan, reporting all that is wrong at once.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/index.hpp"
#include "base/text.hpp"
#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"
#include "compose/composition_plan.hpp"
#include "spec/check.hpp"

namespace binnacle::internal::compose {

using namespace spec;
using base::as_size;
using base::count_of;
using base::index_of;
using base::listed;
using base::names_of;
using base::suggestion;

/// A component on its way from JSON to object: what its constructor is handed.
struct Component {
  Reader at;
  std::string name;
  std::size_t failures = 0;             // when it began to be read: with one more it is not made
  const ComponentType* type = nullptr;  // null: there is no such type
  ParameterValue parameters = {};
  std::vector<int> values = {};  // what is plugged into its ports, −1: nothing
  std::vector<PortBinding> ports = {};
  std::vector<int> driving_rates = {};  // index of each in the driving input
  std::vector<bool> fields_bound = {};  // its own, then those of its inputs
  std::vector<bool> inputs_bound = {};
  std::vector<const ChannelDeclaration*> channels = {};  // by input
  std::vector<std::vector<NamedUnit>> covariances = {{}};
  int samples_per_step = 1;

  const ComponentSpec& spec() const { return type->spec; }
};

/// Which of an enumeration's names stands at a place, or nothing; another is an error: `an update is …; found 'x'`.
template <class Enum, std::size_t count>
std::optional<Enum> read_name(const Reader& at, const char* const (&names)[count], const std::string& expected) {
  const auto name = at.text();
  if (!name) return std::nullopt;
  const std::vector<std::string> known(names, names + count);
  if (const int index = index_of(known, *name); index >= 0) return static_cast<Enum>(index);
  at.error("B009", expected + "; found '" + *name + "'" + suggestion(*name, known));
  return std::nullopt;
}

template <class Plan>
Plan planned(const Reader& at) {
  Plan plan;
  plan.name = at.key();
  plan.pointer = at.pointer();
  return plan;
}

class Composer;

/// One filter on its way from JSON to plan. What failed is left out and remembered, so that nothing which depends on it
/// is reported on top.
class FilterComposer {
 public:
  /// Its blocks and the channel of its estimates (blocks.cpp).
  FilterComposer(Composer& composer, const Reader& at);
  /// All else, once every channel is known (models.cpp).
  void finish();

  /// What the ports of one of its models are plugged into.
  void bind_ports(Component& component);
  void find_driving_rates(Component& component);
  void read_auxiliary(AuxiliaryPlan& auxiliary, Component& component);
  /// Whether those that a model declares Jacobians for are bound.
  bool are_bound(const std::vector<int>& read_ports, const Component& component);
  /// The derived values among them, and those that these depend on, in order.
  std::vector<int> derived_closure(std::vector<int> values) const;
  /// Fills `info` from the plan, as far as it got (infos.cpp).
  void describe();
  void fail();
  std::size_t reserve(std::size_t doubles) {
    const std::size_t offset = plan.workspace;
    plan.workspace += doubles;
    return offset;
  }

  Composer& composer;
  Reader at;
  FilterPlan plan;
  FilterInfo info;
  std::vector<PortBinding> values;      // what ports may be plugged into: blocks, then derived
  std::set<std::string> failed_values;  // names whose own error is reported already
  bool is_complete = true;

 private:
  void add_block(const Reader& block_at);
  void publish_estimates();
  void read_initial_values();
  void find_input();
  /// Among the values, −1: it cannot be bound.
  int value_for(const PortSpec& port, const std::string& type, const Reader& port_at);
  void add_derived();
  bool add_derived_block(const Reader& derived_at);
  void add_processes();
  /// `is_whole`: all before it are.
  bool add_process(const Reader& process_at, bool is_whole);
  void read_process_input(ProcessPlan& process, Component& component);
  void add_measurements();
  void read_trust();  // trust.cpp
  void read_forms();
  void read_history(const ChannelDeclaration& estimates);
  void warn_of_dead_reckoning() const;
  void warn_of_gates() const;
};

class Composer {
 public:
  Composer(Document document, const LoadOptions& options, Diagnostics& diagnostics);

  /// Null when there are errors.
  std::unique_ptr<CompositionPlan> compose();

  CompositionPlan& plan() { return *plan_; }
  const ChannelPlan& channel(int index) const { return plan_->channels[as_size(index)]; }
  Reader place(const std::string& pointer) const { return {plan_->document, diagnostics_, pointer}; }
  Diagnostics& diagnostics() { return diagnostics_; }
  const std::vector<std::shared_ptr<const Section>>& sections() const { return sections_; }
  void add_subscriber(int channel, const std::string& pointer);
  const std::vector<FilterComposer>& filters() const { return filters_; }

  /// How much went wrong so far. What is composed is whole if this has not changed meanwhile.
  std::size_t failures() const;
  /// Of what is reported elsewhere.
  void fail() { ++silent_failures_; }
  /// Its channels are unknown: what subscribes to them is not reported on top.
  void fail_component(const std::string& name) { failed_components_.insert(name); }

  /// Type, ports and driving rates (of a filter's models) and parameters; `reserved` are the keys of its place.
  Component read_component(Role role, const Reader& at, const std::vector<std::string>& reserved,
                           FilterComposer* filter = nullptr);
  /// Null where something is wrong with the component or it refuses.
  template <class Base>
  std::shared_ptr<Base> make(const Component& component, const NoiseBinding& noise = {}) {
    if (component.failures != failures()) return nullptr;
    Findings findings;
    try {
      const Binding binding({.name = component.name,
                             .parameters = Parameters(component.parameters),
                             .ports = component.ports,
                             .fields_bound = component.fields_bound,
                             .samples_per_step = component.samples_per_step,
                             .covariances = component.covariances,
                             .spec = &component.spec(),
                             .inputs_bound = component.inputs_bound,
                             .channels = component.channels,
                             .has_driving_rates = !component.driving_rates.empty(),
                             .findings = &findings});
      auto object = component.type->create<Base>(binding, noise);
      keep(std::move(findings), component.at);
      return object;
    } catch (const ComponentError& error) {
      refuse(error, component.at);
      return nullptr;
    }
  }

  /// By their names under "inputs"; a transform or sink may write "input" for its first. The "input" of a model is another.
  std::vector<NodeInput> read_inputs(Component& component);
  /// −1 when there is no such channel: an error, but where its source failed on its own.
  int channel_named(const std::string& name, const Reader& at);
  std::vector<int> add_channels(const Reader& component, const std::vector<ChannelDeclaration>& declarations);
  /// `at`: of the component, which may map them under "fields" among all that are `mappable`.
  FieldMap map_fields(const std::vector<FieldSpec>& wanted, int channel, const Reader& channel_at, const Reader& at,
                      const std::string& type, const std::vector<FieldSpec>& mappable);
  /// The same of a component's own fields, or of an input's; `first` is the place of the first in what it has bound.
  FieldMap bind_fields(Component& component, const std::vector<FieldSpec>& wanted, int channel,
                       const Reader& channel_at, std::size_t first = 0);
  /// Adds each of the section's names as soon as it waits for none of the others; those that wait for each other are a
  /// cycle, which is reported and returned.
  template <class IsWaiting, class Add>
  std::vector<std::string> in_order(const Reader& section, const char* what, const IsWaiting& is_waiting,
                                    const Add& add) {
    std::vector<std::string> open;
    for (const Reader& item : section.children()) open.push_back(item.key());
    while (!open.empty()) {
      std::vector<std::string> later;
      for (const auto& name : open) {
        if (is_waiting(section[name], open))
          later.push_back(name);
        else
          add(section[name]);
      }
      if (later.size() == open.size()) {
        section[later.front()].error("B023", what + listed(later));
        return later;
      }
      open = later;
    }
    return {};
  }
  void check_section_keys(const Reader& at, std::vector<std::string> own, const std::string& what);

 private:
  // composition.cpp
  void read_head();
  /// What grows with the square of a section's size stays within seconds.
  bool are_sections_small() const;
  bool load_plugins();
  void order_nodes();
  void lay_out();
  /// The node, the channel that it subscribes to, and the JSON pointer of the part of the node that reads it.
  using VisitInput = std::function<void(const Node&, int channel, const std::string& pointer)>;
  void for_each_input(const VisitInput& visit) const;
  void plan_history();  // history.cpp
  void add_subscribers();
  void check_subscribers();
  void keep(Findings findings, const Reader& at);
  void refuse(const ComponentError& error, const Reader& at);

  // channels.cpp
  void add_sources();
  void add_transforms();
  void add_sinks();

  std::unique_ptr<CompositionPlan> plan_;
  std::vector<std::shared_ptr<const Section>> sections_;
  std::vector<std::shared_ptr<const LinkedPlugin>> linked_plugins_;
  std::vector<std::filesystem::path> plugin_folders_;
  Diagnostics& diagnostics_;
  std::map<std::string, const ComponentType*> used_;  // one of each plugin
  std::set<std::string> failed_components_;           // sources and transforms whose channels are unknown
  std::vector<FilterComposer> filters_;
  std::size_t silent_failures_ = 0;
  mutable std::size_t seen_ = 0, errors_ = 0;  // of the diagnostics, which only grow
};

/// Index of the channel among those whose latest sample is kept, added if it is new.
int latest_of(std::vector<LatestPlan>& kept, int channel);

/// How long samples of a source are on their way; nothing where the config says nothing or something wrong (history.cpp).
std::optional<LatencyPlan> read_latency(const Reader& latency, const std::vector<ChannelDeclaration>& channels);

/// The structure of Φ and Qd, also as `info` has it (transition.cpp).
void plan_transition(FilterComposer& filter);

}  // namespace binnacle::internal::compose
