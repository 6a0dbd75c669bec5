// SPDX-License-Identifier: Apache-2.0
// From a document to a CompositionPlan, reporting all that is wrong at once.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/index.hpp"
#include "base/text.hpp"
#include "binnacle/composition.hpp"
#include "compose/composition_plan.hpp"
#include "spec/check.hpp"
#include "spec/kind.hpp"

namespace binnacle::compose {

using base::as_size;
using base::listed;
using base::names_of;
using base::suggestion;

/// A block or derived block as ports see it.
struct ValueInfo {
  std::string name;
  std::string kind;
  int dof = 0;
  int stored_size = 0;
  std::vector<NamedUnit> components;
  bool is_derived = false;
};

/// One filter on its way from JSON to plan. What failed is left out and remembered, so that nothing which depends on it
/// is reported on top.
struct FilterBuild {
  FilterPlan plan;
  std::string pointer;
  std::vector<ValueInfo> values;        // blocks, then derived
  std::set<std::string> failed_values;  // names whose own error is reported already
  std::map<std::string, int> initial_channels;
  bool blocks_complete = true;
  bool is_complete = true;

  int value(std::string_view name) const {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i].name == name) return static_cast<int>(i);
    return -1;
  }
  std::size_t reserve(std::size_t doubles) {
    const std::size_t offset = plan.workspace;
    plan.workspace += (doubles + 1) / 2 * 2;
    return offset;
  }
};

/// A component on its way from JSON to object: what its constructor is handed.
struct Component {
  std::string name;
  std::string pointer;
  const ComponentType* type = nullptr;  // null: there is no such type
  ParameterValue parameters = {};
  std::vector<int> values = {};  // what is plugged into its ports, −1: nothing
  std::vector<PortBinding> ports = {};
  std::vector<int> driving_rates = {};  // index of each in the driving input
  std::vector<bool> fields_bound = {};  // its own, then those of its inputs
  std::vector<bool> inputs_bound = {};
  std::vector<std::vector<NamedUnit>> covariances = {{}};
  int samples_per_step = 1;
  bool is_whole = false;  // false: something is wrong with it, or with what it is plugged into

  const ComponentSpec& spec() const { return type->spec; }
  /// Which fields a channel carries, of those that `first` is the first of.
  void bind_fields(const FieldMap& map, std::size_t first = 0) {
    for (const auto* items : {&map.epoch, &map.row})
      for (const auto& item : *items) fields_bound[first + as_size(item.declared)] = item.index >= 0;
  }
};

template <class Plan>
Plan planned(const std::string& name, const std::string& pointer) {
  Plan plan;
  plan.name = name;
  plan.pointer = pointer;
  return plan;
}

class Composer {
 public:
  Composer(Document document, const LoadOptions& options, Diagnostics& diagnostics);

  /// Null when there are errors.
  std::unique_ptr<CompositionPlan> compose();
  /// Whether what is wrong is (also) the plugins', or only the data's.
  bool has_load_errors() const { return load_errors_; }
  bool has_config_errors() const { return config_errors_; }

 private:
  // composition.cpp
  void read_head();
  void load_plugins();
  void order_nodes();
  void lay_out();
  void warn_of_unheard();

  // channels.cpp
  void add_sources();
  void add_transforms();
  bool add_transform(const std::string& name, const std::string& pointer);
  void add_sinks();
  Component read_stage(Role role, const std::string& name, const std::string& pointer, std::vector<NodeInput>& inputs);
  void add_channels(const std::string& component, const std::string& pointer,
                    const std::vector<ChannelDeclaration>& declarations, std::vector<int>& indices);
  /// By their names under "inputs"; a transform or sink may write "input" for its first. The "input" of a model is another.
  bool read_inputs(Component& component, std::vector<NodeInput>& inputs);
  /// −1 with an error when there is no such channel (no error when its source failed on its own).
  int channel_named(const std::string& name, const std::string& pointer, bool& is_told);
  /// Whether a channel's field can serve as the wanted one, with what conversion; reports why not.
  bool fits(const FieldSpec& wanted, const FieldSpec& found, const ChannelPlan& channel, const std::string& pointer,
            const std::string& type, FieldMap::Conversion& conversion);
  bool map_fields(const std::vector<FieldSpec>& wanted, int channel, const std::string& component_pointer,
                  const std::string& channel_pointer, const std::string& type, FieldMap& map,
                  const std::vector<FieldSpec>& mappable = {});

  // blocks.cpp
  void begin_filters();
  void add_block(FilterBuild& build, const std::string& name, const std::string& pointer);
  void read_uses(BlockPlan& block, const std::string& pointer);
  void read_initial(FilterBuild& build, BlockPlan& block, const std::string& pointer);
  bool read_initial_values(const BlockPlan& block, const std::string& pointer, std::vector<double>& values);
  void read_initial_channel(FilterBuild& build, BlockPlan& block, const std::string& init_pointer);
  void find_initial_covariance(BlockPlan& block, int channel, const std::string& covariance_pointer);
  void read_sigma(FilterBuild& build, BlockPlan& block, const std::string& pointer);
  void publish_estimates(FilterBuild& build);

  // models.cpp
  void finish_filters();
  void find_input(FilterBuild& build);
  void check_port_names(const ComponentSpec& spec, const std::string& blocks_pointer);
  /// False where it is of no use and the reason is reported elsewhere, or not a name.
  bool bind_port(const FilterBuild& build, const PortSpec& port, const std::string& type, const std::string& pointer,
                 int& value, PortBinding& binding);
  bool bind_ports(FilterBuild& build, Component& component);
  bool find_driving_rates(FilterBuild& build, Component& component);
  bool read_auxiliary(FilterBuild& build, AuxiliaryPlan& auxiliary, Component& component);
  void add_derived(FilterBuild& build);
  bool add_derived_block(FilterBuild& build, const std::string& name, const std::string& pointer);
  std::vector<int> derived_closure(const FilterBuild& build, const std::vector<int>& values) const;
  void add_processes(FilterBuild& build);
  bool add_process(FilterBuild& build, const std::string& name, const std::string& pointer, bool is_whole,
                   std::vector<int>& values_read);
  bool read_process_input(FilterBuild& build, ProcessPlan& plan, Component& component);
  bool check_couplings(const ProcessPlan& plan, const Component& component);
  void advance_blocks(FilterBuild& build, const ProcessPlan& plan, const ComponentSpec& spec,
                      std::vector<int>& values_read);

  // measurements.cpp
  void add_measurements(FilterBuild& build);
  bool add_measurement(FilterBuild& build, const std::string& name, const std::string& pointer);
  bool add_part(FilterBuild& build, MeasurementPlan& measurement, const std::string& name, const std::string& pointer,
                const std::vector<std::string>& reserved);
  bool read_part_fields(const MeasurementPlan& measurement, PartPlan& part, Component& component);
  bool reserve_reads(FilterBuild& build, PartPlan& part, const Component& component);
  bool reads_bound_ports(const std::vector<int>& read_ports, const Component& component);
  void add_gate(MeasurementPlan& measurement, const std::string& pointer);
  void add_noise(FilterBuild& build, MeasurementPlan& measurement, const std::string& pointer);
  void add_recovery(FilterBuild& build, MeasurementPlan& measurement, const std::string& pointer);
  void add_withholding(MeasurementPlan& measurement, const std::string& pointer);
  void collect_touched(FilterBuild& build, MeasurementPlan& measurement);

  // transition.cpp
  void plan_transition(FilterBuild& build);

  // sections.cpp
  friend class Draft;
  void check_section_keys(const std::string& pointer, std::vector<std::string> own, const std::string& what);
  void read_sections();

  // shared
  /// The object's type, found in the catalog; null with an error.
  const ComponentType* type_of(Role role, const std::string& pointer);
  /// Type, ports and driving rates (of a filter's models) and parameters; `reserved` are the keys of its place.
  Component read_component(Role role, const std::string& name, const std::string& pointer,
                           const std::vector<std::string>& reserved, FilterBuild* build = nullptr);
  /// Null where the component refuses; `then` is asked of it with the same care.
  template <class Base>
  std::shared_ptr<Base> make(const Component& component, const NoiseBinding& noise = {},
                             const std::function<void(const Base&)>& then = {}) {
    std::shared_ptr<Base> object;
    const bool is_made = guarded(component.pointer, [&](Findings& findings) {
      object = component.type->create<Base>(Binding(component.name, Parameters(component.parameters), component.ports,
                                                    component.fields_bound, component.samples_per_step,
                                                    component.covariances)
                                                .of(component.spec(), component.inputs_bound,
                                                    !component.driving_rates.empty())
                                                .reporting_to(findings),
                                            noise);
      if (then) then(*object);
    });
    return is_made ? object : nullptr;
  }
  /// Adds each of the names as soon as it waits for none of the others; those that wait for each other are a cycle, which
  /// is reported and returned.
  template <class IsWaiting, class Add>
  std::vector<std::string> in_order(const std::string& section, const char* what, const IsWaiting& is_waiting,
                                    const Add& add) {
    std::vector<std::string> open;
    for (const auto& item : at(section)->items()) open.push_back(item.key());
    while (!open.empty()) {
      std::vector<std::string> later;
      for (const auto& name : open) {
        if (is_waiting(name, open))
          later.push_back(name);
        else
          add(name, join_pointer(section, name));
      }
      if (later.size() == open.size()) {
        error("B023", join_pointer(section, later.front()), what + listed(later));
        return later;
      }
      open = later;
    }
    return {};
  }
  /// Runs `create`, turning a ComponentError into a diagnostic, and keeps what the component found. False when it was
  /// refused.
  template <class Create>
  bool guarded(const std::string& pointer, Create&& create) {
    Findings findings;
    try {
      create(findings);
    } catch (const ComponentError& error) {
      refuse(error, pointer);
      return false;
    }
    keep(std::move(findings), pointer);
    return true;
  }
  void keep(Findings findings, const std::string& pointer);
  void refuse(const ComponentError& error, const std::string& pointer);
  void error(const std::string& code, const std::string& pointer, const std::string& message);
  void key_error(const std::string& code, const std::string& pointer, const std::string& message);
  std::size_t error_count() const;
  const nlohmann::ordered_json* at(const std::string& pointer) const { return value_at(document(), pointer); }
  const Document& document() const { return plan_->document; }

  std::unique_ptr<CompositionPlan> plan_;
  std::vector<std::shared_ptr<const Section>> sections_;
  Diagnostics& diagnostics_;
  std::set<std::string> failed_components_;  // sources and transforms whose channels are unknown
  std::vector<FilterBuild> builds_;
  bool load_errors_ = false;
  bool config_errors_ = false;
};

/// All fields that the one key "fields" of a component may map: of its sample and of all its inputs.
std::vector<FieldSpec> mappable_fields(const ComponentSpec& spec);

/// CompositionPlan::subscribers, as far as it got.
std::vector<std::vector<std::string>> subscribers(const CompositionPlan& plan);

/// What a Composition says of its filters; of an unfinished one, as far as it got.
std::vector<FilterInfo> filter_infos(const CompositionPlan& plan);
std::vector<ChannelInfo> channel_infos(const CompositionPlan& plan);

}  // namespace binnacle::compose
