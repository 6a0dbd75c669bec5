// SPDX-License-Identifier: Apache-2.0
// State blocks of a filter: which components are estimated, first values and their uncertainty.
#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>

#include "compose/composer.hpp"

namespace binnacle::internal::compose {

namespace {

/// What the config says of one block beside its parameters.
class BlockReader {
 public:
  BlockReader(FilterComposer& filter, BlockPlan& block) : filter_(filter), block_(block) {}

  void read_uses() {
    const auto estimate = components_at(at_["estimate"]), consider = components_at(at_["consider"]);
    block_.use.assign(components_.size(), estimate ? Use::frozen : Use::estimated);
    for (const int i : estimate.value_or(std::vector<int>())) block_.use[as_size(i)] = Use::estimated;
    for (const int i : consider.value_or(std::vector<int>())) {
      if (estimate && block_.use[as_size(i)] == Use::estimated)
        at_["consider"].error("B014", "component '" + components_[as_size(i)] + "' of " + what_ +
                                          " cannot be both estimated and considered");
      block_.use[as_size(i)] = Use::considered;
    }
    for (std::size_t i = 0; i < components_.size(); ++i)
      if (block_.use[i] != Use::frozen) block_.active.push_back(static_cast<int>(i));
    block_.holds_frozen = at_["hold"].boolean().value_or(false);
  }

  void read_initial() {
    const Reader init = at_["init"];
    const std::size_t failures = filter_.composer.failures();
    if (init["channel"]) return read_initial_channel(init);
    if (init["again"])
      return init["again"].error("B010", "an initial value restarts from a channel: \"again\": {\"channel\": …}");
    std::vector<double> values(declaration_.outputs.size(), 0.0);
    read_initial_values(init, values);
    if (filter_.composer.failures() != failures) return;
    block_.initial.value.assign(as_size(declaration_.stored_size), 0.0);
    try {
      const auto error = [](const std::string& text) { return ComponentError(text); };
      const Result result = call_plugin(
          nullptr, block_.type, "write", no_time, [&] { return block_.block->write(values, block_.initial.value); },
          error);
      if (!result) init.error("B030", what_ + " refuses its initial value: " + result.reason);
    } catch (const ComponentError& error) {
      init.error("B045", error.what());
    }
  }

  void read_sigma() {
    const Reader sigma = at_["sigma"];
    InitialPlan& initial = block_.initial;
    initial.sigma.assign(components_.size(), std::numeric_limits<double>::quiet_NaN());
    const bool is_whole = read_values(sigma, components_, "'sigma' of " + what_, "'sigma' of " + what_,
                                      [&](const Reader& at, std::size_t i) {
                                        const auto spec =
                                            parameter::number("sigma", declaration_.error[i].unit).at_least(0);
                                        initial.sigma[i] = at.number(spec).value_or(initial.sigma[i]);
                                      });
    if (!is_whole) return filter_.fail();
    if (block_.again) {
      block_.again->sigma = initial.sigma;
      require_sigma(sigma, *block_.again);
    }
    require_sigma(sigma, initial);
  }

 private:
  void require_sigma(const Reader& sigma, const InitialPlan& initial) {
    // A channel that could not be found is reported already.
    if (initial.channel < 0 && at_["init"]["channel"]) return;
    if (initial.channel >= 0 && !initial.covariance.empty()) return;
    const auto missing = std::ranges::find_if(block_.active, [&](int i) {
      return !sigma || (sigma.is_object() && !sigma[components_[as_size(i)]]);
    });
    if (missing == block_.active.end()) return;
    const NamedUnit& component = declaration_.error[as_size(*missing)];
    at_.key_error("B026", "'sigma' of " + what_ + " is missing for '" + component.name + "' (" + component.unit + ")" +
                              (initial.channel < 0
                                   ? ""
                                   : ": channel '" + channel_of(initial).name + "' carries no covariance for it"));
  }

  /// Nothing where the key is not there.
  std::optional<std::vector<int>> components_at(const Reader& place) const {
    if (!place) return std::nullopt;
    std::vector<int> found;
    if (config::JsonOf::at(place).is_boolean()) {
      if (config::JsonOf::at(place).get<bool>()) found.resize(components_.size());
      std::iota(found.begin(), found.end(), 0);
      return found;
    }
    for (const auto& name : place.names().value_or(std::vector<std::string>())) {
      found.push_back(index_of(components_, name));
      if (found.back() >= 0) continue;
      found.pop_back();
      place.error("B025", what_ + " has no component '" + name + "'" + suggestion(name, components_) + " (" +
                              listed(components_) + ")");
    }
    return found;
  }

  /// An object with these names, a list of as many, or one value for all. False where a list has another length.
  static bool read_values(const Reader& place, const std::vector<std::string>& names, const std::string& what_object,
                          const std::string& what_list, const std::function<void(const Reader&, std::size_t)>& read) {
    if (!place) return true;
    const bool is_object = place.is_object(), is_list = place.is_list();
    if (is_object) place.check_keys(names, what_object);
    if (is_list && config::JsonOf::at(place).size() != names.size()) {
      place.error("B013", what_list + " has " + std::to_string(names.size()) + " elements (" + listed(names) +
                              "); found " + std::to_string(config::JsonOf::at(place).size()));
      return false;
    }
    const std::vector<Reader> elements = is_list ? place.children() : std::vector<Reader>();
    for (std::size_t i = 0; i < names.size(); ++i) read(is_object ? place[names[i]] : is_list ? elements[i] : place, i);
    return true;
  }

  void read_initial_values(const Reader& init, std::vector<double>& values) {
    const auto& outputs = declaration_.outputs;
    const bool starts_at_zero = declaration_.starts_at_zero;
    const auto names = names_of(outputs);
    if (!init) {
      if (!starts_at_zero)
        at_.key_error("B026", "the initial value of " + what_ + " is missing: \"init\": {\"" +
                                  (names.empty() ? "…" : names.front()) + "\": …} or {\"channel\": …}");
      return;
    }
    const bool is_single = !config::JsonOf::at(init).is_structured();
    if (is_single && outputs.size() != 1 && !starts_at_zero)
      return init.error("B006", "the initial value of " + what_ + " is an object with " + listed(names) +
                                    ", or {\"channel\": …}; found " + init.shown());
    read_values(init, names, "'init' of " + what_, "the initial value of " + what_,
                [&](const Reader& at, std::size_t i) {
                  const auto& output = outputs[is_single ? 0 : i];
                  const auto spec = parameter::number(is_single ? "init" : output.name, output.unit);
                  values[i] = at.number(spec).value_or(0.0);
                  if (!at && !starts_at_zero)
                    init.key_error("B026", "'" + output.name + "' of the initial value of " + what_ + " is missing");
                });
  }

  void read_initial_channel(const Reader& init) {
    init.check_keys({"channel", "fields", "max_age", "covariance", "again"}, "'init' of " + what_);
    LatestPlan* const latest = read_channel(init, block_.initial);
    if (!latest) return;
    latest->is_of_start = true;
    const Reader again = init["again"];
    if (!again.is_object()) {
      latest->is_of_restart |= again.boolean().value_or(false);
      return;
    }
    again.check_keys({"channel", "fields", "max_age", "covariance"}, "'again' of " + what_);
    block_.again.emplace();
    if (!again["channel"])
      again.key_error("B010", "'again' of " + what_ + " is true, or {\"channel\": …}");
    else if (LatestPlan* const other = read_channel(again, *block_.again))
      other->is_of_restart = true;
  }

  /// Null where it failed.
  LatestPlan* read_channel(const Reader& init, InitialPlan& initial) {
    Composer& composer = filter_.composer;
    const auto name = init["channel"].text();
    if (!name) return nullptr;
    const int channel = composer.channel_named(*name, init["channel"]);
    if (channel < 0) {
      filter_.fail();
      return nullptr;
    }
    std::vector<FieldSpec> wanted;
    for (const auto& output : declaration_.outputs) wanted.push_back(field::level(output.name, output.unit));
    const std::size_t failures = composer.failures();
    const FieldMap map = composer.map_fields(wanted, channel, init["channel"], init, block_.type, wanted);
    if (composer.failures() != failures) return nullptr;
    for (const auto& item : map.epoch) initial.fields.push_back(item.index);
    const Time max_age = init["max_age"].time().value_or(0);
    if (max_age < 0) init["max_age"].error("B009", "'max_age' is a time of at least 0 s");
    initial.channel = latest_of(filter_.plan.initial, channel);
    auto& latest = filter_.plan.initial[as_size(initial.channel)];
    if (max_age > 0) latest.max_age = latest.max_age == 0 ? max_age : std::min(latest.max_age, max_age);
    find_initial_covariance(init["covariance"], initial);
    return &latest;
  }

  const ChannelPlan& channel_of(const InitialPlan& initial) const {
    return filter_.composer.channel(filter_.plan.initial[as_size(initial.channel)].channel);
  }

  /// Which components of the sample's covariance are this block's: "BLOCK.north", "position.north" or "north".
  void find_initial_covariance(const Reader& place, InitialPlan& initial) {
    const auto names = names_of(channel_of(initial).declaration.covariance);
    if (names.empty()) return;
    const auto wanted = place.names().value_or(std::vector<std::string>());
    const std::string family = declaration_.kind.substr(0, declaration_.kind.find_first_of(".:"));
    auto& covariance = initial.covariance;
    for (std::size_t c = 0; c < components_.size(); ++c) {
      std::vector<std::string> candidates{block_.name + "." + components_[c], family + "." + components_[c],
                                          components_[c]};
      if (c < wanted.size()) candidates = {wanted[c]};
      const auto found = std::ranges::find_if(candidates, [&](const std::string& candidate) {
        return index_of(names, candidate) >= 0;
      });
      if (found == candidates.end()) return covariance.clear();
      covariance.push_back(index_of(names, *found));
    }
  }

  FilterComposer& filter_;
  BlockPlan& block_;
  const StateBlockDeclaration& declaration_ = block_.declaration();
  const std::vector<std::string> components_ = names_of(declaration_.error);
  const Reader at_ = filter_.composer.place(block_.pointer);
  const std::string what_ = "block '" + block_.name + "'";
};

}  // namespace

FilterComposer::FilterComposer(Composer& its_composer, const Reader& its_place)
    : composer(its_composer), at(its_place), plan(planned<FilterPlan>(its_place)) {
  composer.check_section_keys(at,
                              {"blocks", "derived", "process", "measurements", "trust", "longest_bridge", "history",
                               "emit", "covariance", "propagation"},
                              "filter '" + plan.name + "'");
  const auto blocks = at["blocks"].members("'blocks'");
  if (blocks.empty()) {
    at.key_error("B010", "filter '" + plan.name + "' has no 'blocks'");
    is_complete = false;
  }
  for (const Reader& block : blocks) add_block(block);
  read_forms();
  publish_estimates();
}

/// In which form P is kept, and how it is propagated.
void FilterComposer::read_forms() {
  const auto kind =
      read_name<CovarianceKind>(at["covariance"], covariance_names, "P is kept as joseph, ud or square_root");
  plan.covariance_kind = kind.value_or(plan.covariance_kind);
  enum class Way { ekf, unscented };
  static constexpr const char* ways[] = {"ekf", "unscented"};
  plan.is_unscented =
      read_name<Way>(at["propagation"], ways, "'propagation' is \"ekf\" or \"unscented\"") == Way::unscented;
}

void FilterComposer::add_block(const Reader& block_at) {
  auto block = planned<BlockPlan>(block_at);
  const Component component =
      composer.read_component(Role::state_block, block_at, {"type", "init", "sigma", "estimate", "consider", "hold"});
  block.block = composer.make<StateBlock>(component);
  const auto kind = canonical_kind(block.block ? block.declaration().kind : "*");
  if (!kind) block_at.error("B030", kind.error());
  if (!block.block || !kind) {
    failed_values.insert(block.name);
    return fail();
  }
  block.type = component.type->full_name();
  const auto& declaration = block.declaration();
  values.push_back({block.name, true, *kind, declaration.dof(), declaration.stored_size, declaration.error});
  BlockReader(*this, block).read_uses();
  values.back().is_estimated = !block.active.empty();
  block.stored_offset = plan.stored_size;
  plan.stored_size += block.stored_size = declaration.stored_size;
  block.first = plan.n;
  plan.n += count_of(block.active);
  plan.blocks.push_back(std::move(block));
  if (composer.failures() != component.failures) is_complete = false;
}

void FilterComposer::publish_estimates() {
  if (!failed_values.empty()) return composer.fail_component(plan.name);
  ChannelDeclaration declaration;
  for (const auto& block : plan.blocks) {
    for (const auto& output : block.declaration().outputs)
      declaration.fields.push_back(field::level(block.name + "." + output.name, output.unit).about(output.text));
    for (const int active : block.active) {
      const auto& component = block.declaration().error[as_size(active)];
      declaration.covariance.push_back({block.name + "." + component.name, component.unit});
    }
  }
  plan.output_channel = composer.add_channels(at, {declaration}).front();
  read_history(declaration);
  if (const Reader emit = at["emit"]) {
    const auto when = emit.text();
    plan.emits_input = when == "input";
    if (when && !plan.emits_input && *when != "measurements")
      emit.error("B010", "'emit' is \"measurements\" or \"input\"; found " + emit.shown());
  }
  for (const auto& section : composer.sections())
    for (const auto& name : section->filter_channels(at)) {
      declaration.name = name;
      plan.further_channels.push_back(composer.add_channels(at, {declaration}).front());
    }
}

void FilterComposer::read_initial_values() {
  for (auto& block : plan.blocks) {
    BlockReader reader(*this, block);
    reader.read_initial();
    reader.read_sigma();
  }
  const bool starts_anew = std::ranges::any_of(plan.initial, &LatestPlan::is_of_restart);
  const Reader longest = at["longest_bridge"];
  if (longest && !starts_anew)
    longest.error("B010", "'longest_bridge' needs an 'init' with \"again\": without one the filter cannot restart");
  constexpr Time default_longest = 10 * nanoseconds_per_second;
  if (starts_anew) plan.longest_bridge = longest.time().value_or(default_longest);
}

}  // namespace binnacle::internal::compose
