// SPDX-License-Identifier: Apache-2.0
// Measurements of a filter: models and stacks of them, fields, noise, gates, recovery.
#include <algorithm>
#include <map>

#include <boost/math/distributions/chi_squared.hpp>

#include "compose/composer.hpp"

namespace binnacle::internal::compose {

namespace {

const std::vector<std::string> part_keys = {"type", "blocks", "fields", "inputs", "systematic"};

/// One measurement on its way from JSON to plan.
class MeasurementComposer {
 public:
  MeasurementComposer(FilterComposer& filter, const Reader& at)
      : filter_(filter), composer_(filter.composer), at_(at), plan_(planned<MeasurementPlan>(at)) {}

  bool compose() {
    const std::size_t failures = composer_.failures();
    if (!at_.is_object("measurement '" + plan_.name + "'")) return false;
    if (!at_.require("channel", plan_.name, "name of a channel")) return false;
    const auto channel = at_["channel"].text();
    if (!channel) return false;
    plan_.channel = composer_.channel_named(*channel, at_["channel"]);
    add_parts();
    if (composer_.failures() != failures) return false;
    collect_touched();
    add_gate();
    add_noise();
    add_recovery();
    add_withholding();
    add_update();
    if (composer_.failures() != failures) return false;
    FilterPlan& filter = filter_.plan;
    filter.max_rows = std::max(filter.max_rows, plan_.max_rows);
    filter.max_columns = std::max(filter.max_columns, count_of(plan_.columns));
    filter.measurements.push_back(std::move(plan_));
    return true;
  }

 private:
  void add_parts() {
    std::vector<std::string> allowed{"channel", "noise", "gate", "recover", "withhold", "update"};
    const Reader stack = at_["stack"];
    if (!stack) {
      allowed.insert(allowed.end(), part_keys.begin(), part_keys.end());
      return add_part(at_, allowed);
    }
    allowed.emplace_back("stack");
    at_.check_keys(allowed, "stack '" + plan_.name + "'");
    const auto parts = stack.members("'stack'");
    if (parts.empty() && stack.is_object()) stack.error("B010", "the stack '" + plan_.name + "' is empty");
    for (const Reader& part : parts) add_part(part, part_keys);
  }

  void add_part(const Reader& at, const std::vector<std::string>& reserved) {
    auto part = planned<PartPlan>(at);
    Component component = composer_.read_component(Role::measurement_model, at, reserved, &filter_);
    if (!component.type) return;
    part.type = component.type->full_name();
    part.ports = component.values;
    part.driving_rates = component.driving_rates;
    if (plan_.channel >= 0) {
      part.fields = composer_.bind_fields(component, component.spec().fields, plan_.channel, at_["channel"]);
      component.covariances = {composer_.channel(plan_.channel).declaration.covariance};
    }
    filter_.read_auxiliary(part.auxiliary, component);
    // What is wrong with the channel is reported; its missing fields are not the model's to complain of.
    if (plan_.channel < 0) return;
    part.model = composer_.make<MeasurementModel>(component);
    if (!part.model || !reserve_reads(part, component)) return;
    plan_.max_rows += part.model->declaration().max_rows;
    add_groups(part, at["systematic"]);
    plan_.parts.push_back(std::move(part));
  }

  /// A mean of its rows that is no reason against the estimates, in their unit.
  void add_groups(const PartPlan& part, const Reader& systematic) {
    const auto add = [&](const std::string& unit) {
      plan_.systematic.push_back(systematic.number(parameter::number("systematic", unit).at_least(0)).value_or(0.0));
    };
    const auto& groups = part.model->declaration().groups;
    for (const auto& group : groups) add(unit_of(part, group));
    if (groups.empty()) add("1");
  }

  std::string unit_of(const PartPlan& part, const ResidualGroup& group) const {
    const bool is_ports = group.unit.empty() && group.port >= 0;
    return is_ports ? filter_.values[as_size(part.ports[as_size(group.port)])].components.front().unit : group.unit;
  }

  bool reserve_reads(PartPlan& part, const Component& component) {
    const auto& declaration = part.model->declaration();
    if (declaration.max_rows < 1) component.at.error("B030", "'" + component.spec().type + "' declares no rows");
    if (declaration.max_rows < 1 || !filter_.are_bound(declaration.read_ports, component)) return false;
    for (const int port : declaration.read_ports) {
      const int value = part.ports[as_size(port)];
      const int dof = filter_.values[as_size(value)].dof;
      part.reads.push_back({value, dof, filter_.reserve(as_size(declaration.max_rows * dof)), {}, port});
    }
    return true;
  }

  /// The blocks that a value depends on, each with the Jacobian in between.
  std::vector<DerivedPlan::Dependence> dependences(int value) const {
    if (filter_.plan.is_block(value)) return {{value, 0}};
    return filter_.plan.derived_at(value).dependences;
  }

  void collect_touched() {
    const auto& blocks = filter_.plan.blocks;
    std::vector<int> values;
    std::map<int, int> first_column;  // of each block that has rows in P
    for (const auto& part : plan_.parts) {
      values.insert(values.end(), part.ports.begin(), part.ports.end());
      for (const auto& read : part.reads)
        for (const auto& [block, chain] : dependences(read.value))
          if (!blocks[as_size(block)].active.empty()) first_column[block] = 0;
    }
    plan_.derived = filter_.derived_closure(values);
    for (auto& [block, column] : first_column) {
      column = count_of(plan_.columns);
      for (int a = 0; a < count_of(blocks[as_size(block)].active); ++a)
        plan_.columns.push_back(blocks[as_size(block)].first + a);
      plan_.update.seen.push_back({block, column});
    }
    for (auto& part : plan_.parts)
      for (auto& read : part.reads)
        for (const auto& [block, chain] : dependences(read.value))
          if (const auto found = first_column.find(block); found != first_column.end())
            read.targets.push_back({block, found->second, filter_.plan.is_block(read.value), chain});
  }

  /// `"gate": 0.999` of whole samples, or {"probability": 0.999, "by": "row"} of rows or of keys.
  void add_gate() {
    plan_.gate_limit.assign(as_size(plan_.max_rows) + 1, 0.0);
    const Reader gate = at_["gate"];
    if (!gate) return;
    const bool is_object = gate.is_object();
    if (is_object) {
      gate.check_keys({"probability", "by"}, "'gate'");
      if (!gate.require("probability", "gate", "0 < p < 1")) return;
      plan_.gate_unit =
          read_name<GateUnit>(gate["by"], gate_unit_names, "a gate is by sample, row or key").value_or(plan_.gate_unit);
    }
    const auto spec = parameter::number("gate", "1").about("probability").above(0).below(1);
    plan_.gate = (is_object ? gate["probability"] : gate).number(spec).value_or(0.0);
    if (plan_.gate > 0)
      for (int m = 1; m <= plan_.max_rows; ++m)
        plan_.gate_limit[as_size(m)] = boost::math::quantile(boost::math::chi_squared(m), plan_.gate);
  }

  void add_noise() {
    const Reader noise = at_["noise"];
    if (!noise) return;
    Component component = composer_.read_component(Role::noise_estimator, noise, {"type", "learn_from_gated"});
    component.name = plan_.name;
    plan_.learn_from_gated = noise["learn_from_gated"].boolean().value_or(false);
    if (!component.type) return filter_.fail();
    NoiseBinding binding;
    binding.max_rows = plan_.max_rows;
    for (const auto& part : plan_.parts) {
      const auto& declaration = part.model->declaration();
      for (const auto& group : declaration.groups)
        binding.groups.push_back(
            {plan_.parts.size() > 1 ? part.name + "." + group.name : group.name, unit_of(part, group)});
      if (declaration.groups.empty()) binding.groups.push_back({part.name, ""});
    }
    plan_.noise_type = component.type->full_name();
    plan_.noise = composer_.make<NoiseEstimator>(component, binding);
  }

  /// On by default where there is a gate; `false` turns it off.
  void add_recovery() {
    const Reader recover = at_["recover"];
    if (plan_.gate <= 0) plan_.recover_after = 0;
    if (recover && config::JsonOf::at(recover) == false) {
      plan_.recover_after = 0;
      return;
    }
    if (!recover.is_object("'recover'")) return;
    recover.check_keys({"after", "against", "inflate", "widen"}, "'recover'");
    if (plan_.gate <= 0) recover.error("B010", "'recover' needs a 'gate': without one no sample is ever gated");
    plan_.widens = recover["widen"].boolean().value_or(false);
    const auto after = recover["after"].integer(parameter::integer("after").at_least(1));
    plan_.recover_after = static_cast<int>(after.value_or(plan_.recover_after));
    plan_.recover_against = recover["against"].time().value_or(plan_.recover_against);
    if (plan_.recover_against < 0) recover["against"].error("B009", "'against' is a time of at least 0 s");
    for (const Reader& inflation : recover["inflate"].members("'inflate'")) add_inflation(inflation);
  }

  /// A block's name alone means all of its components.
  void add_inflation(const Reader& inflation) {
    const std::string& key = inflation.key();
    bool is_found = false;
    std::vector<std::string> names;
    for (const auto& block : filter_.plan.blocks)
      for (int a = 0; a < count_of(block.active); ++a) {
        const auto& component = block.declaration().error[as_size(block.active[as_size(a)])];
        names.push_back(block.name + "." + component.name);
        if (key != block.name && key != names.back()) continue;
        is_found = true;
        if (const auto sigma = inflation.number(parameter::number(key, component.unit).at_least(0)))
          plan_.inflations.push_back({block.first + a, *sigma * *sigma});
      }
    if (!is_found)
      inflation.key_error("B025", "there is no estimated component '" + key + "'" + suggestion(key, names));
  }

  void add_withholding() {
    Reader windows = at_["withhold"];
    if (windows.is_object()) {
      windows.check_keys({"every", "windows"}, "'withhold'");
      const auto every = windows["every"].integer(parameter::integer("every").at_least(1).at_most(1'000'000'000));
      plan_.withhold_every = static_cast<int>(every.value_or(0));
      // In a patch over a config it is what was asked for.
      if (plan_.withhold_every == 1 && !composer_.plan().document.is_patched())
        windows["every"].warning("B031", "every sample is withheld: the filter never uses '" + plan_.name + "'");
      windows = windows["windows"];
    }
    for (const Reader& window : windows.elements("'withhold'"))
      if (const auto span = window.span()) plan_.withheld.push_back(*span);
  }

  /// `"update": "iterated"`, or an object with its type and what else it takes.
  void add_update() {
    const Reader update = at_["update"];
    if (!update) return;
    const bool is_object = update.is_object();
    if (is_object && !update.require("type", "update", "\"ekf\", \"iterated\" or \"unscented\"")) return;
    const auto type = read_name<UpdatePlan::Type>(is_object ? update["type"] : update, UpdatePlan::names,
                                                  "an update is ekf, iterated or unscented");
    if (!type) return;
    plan_.update.type = *type;
    if (!is_object) return;
    const bool is_iterated = *type == UpdatePlan::Type::iterated;
    update.check_keys(is_iterated ? std::vector<std::string>{"type", "max", "tolerance"}
                                  : std::vector<std::string>{"type"},
                      "the update '" + std::string(UpdatePlan::names[static_cast<int>(*type)]) + "'");
    if (!is_iterated) return;
    const auto most = update["max"].integer(parameter::integer("max").at_least(1).at_most(1000));
    plan_.update.most = static_cast<int>(most.value_or(plan_.update.most));
    const auto tolerance = update["tolerance"].number(parameter::number("tolerance", "1").above(0).below(1));
    plan_.update.tolerance = tolerance.value_or(plan_.update.tolerance);
  }

  FilterComposer& filter_;
  Composer& composer_;
  const Reader at_;
  MeasurementPlan plan_;
};

}  // namespace

void FilterComposer::add_measurements() {
  for (const Reader& measurement : at["measurements"].members("'measurements'"))
    if (!MeasurementComposer(*this, measurement).compose()) is_complete = false;
}

}  // namespace binnacle::internal::compose
