// SPDX-License-Identifier: Apache-2.0
// From a document to a CompositionPlan, telling all that is wrong in one go.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "binnacle/composition.hpp"
#include "compose/composition_plan.hpp"
#include "config/pointer.hpp"
#include "spec/check.hpp"
#include "spec/kind.hpp"

namespace binnacle::compose {

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
  std::set<std::string> failed_values;  // names whose own error is told already
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
  bool add_transform(const std::string& name);
  Binding stream_binding(const std::string& name, const ComponentSpec& spec, const ParameterValue& parameters,
                         const std::vector<NodeInput>& inputs) const;
  void add_sinks();
  void add_channels(const std::string& component, const std::string& pointer,
                    const std::vector<ChannelDeclaration>& declarations, std::vector<int>& indices);
  /// By their names under "inputs"; a transform or sink may write "input" for its first. The "input" of a model is another.
  bool read_inputs(const ComponentSpec& spec, const std::string& pointer, bool is_model,
                   std::vector<NodeInput>& inputs);
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
  bool bind_ports(FilterBuild& build, const ComponentType& type, const std::string& pointer, std::vector<int>& ports,
                  std::vector<PortBinding>& bindings);
  bool find_driving_rates(FilterBuild& build, const ComponentType& type, const std::string& pointer,
                          std::vector<int>& driving_rates);
  bool read_auxiliary(FilterBuild& build, AuxiliaryPlan& auxiliary, const std::string& pointer,
                      const ComponentSpec& spec, std::vector<bool>& fields_bound, std::vector<bool>& inputs_bound);
  void add_derived(FilterBuild& build);
  bool add_derived_block(FilterBuild& build, const std::string& name, const std::string& pointer);
  bool create_derived(FilterBuild& build, DerivedPlan& plan);
  std::vector<int> derived_closure(const FilterBuild& build, const std::vector<int>& values) const;
  void add_processes(FilterBuild& build);
  bool add_process(FilterBuild& build, const std::string& name, const std::string& pointer, bool is_whole,
                   std::vector<int>& values_read);
  bool read_process_input(FilterBuild& build, ProcessPlan& plan, const ComponentSpec& spec,
                          std::vector<bool>& fields_bound, int& samples_per_step);
  bool check_couplings(const ProcessPlan& plan, const ComponentSpec& spec, const std::vector<PortBinding>& bindings);
  void advance_blocks(FilterBuild& build, const ProcessPlan& plan, const ComponentSpec& spec,
                      std::vector<int>& values_read);

  // measurements.cpp
  void add_measurements(FilterBuild& build);
  bool add_measurement(FilterBuild& build, const std::string& name, const std::string& pointer);
  bool add_part(FilterBuild& build, MeasurementPlan& measurement, const std::string& name, const std::string& pointer,
                const std::vector<std::string>& reserved);
  bool read_part_fields(FilterBuild& build, const MeasurementPlan& measurement, PartPlan& part,
                        const ComponentSpec& spec, std::vector<bool>& fields_bound);
  bool reserve_reads(FilterBuild& build, PartPlan& part, const std::string& type);
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
  PortUnits port_units(const std::vector<PortBinding>& bindings) const;
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

/// Who hears each channel, by JSON pointer.
std::vector<std::vector<std::string>> listeners(const CompositionPlan& plan);

/// What a Composition says of its filters; of an unfinished one, as far as it got.
std::vector<FilterInfo> filter_infos(const CompositionPlan& plan);
std::vector<ChannelInfo> channel_infos(const CompositionPlan& plan);

/// What Composition::explain() gives.
nlohmann::ordered_json explain(const CompositionPlan& plan);

}  // namespace binnacle::compose
