// SPDX-License-Identifier: Apache-2.0
// The order of composing: head, plugins, channels, filters, sections, arena; and what is seen of it meanwhile and after.
#include "binnacle/composition.hpp"

#include <algorithm>

#include "base/hash.hpp"
#include "binnacle/local_axes.hpp"
#include "binnacle/version.hpp"
#include "compose/composer.hpp"
#include "config/node.hpp"
#include "plugin/library.hpp"

namespace binnacle::internal::compose {

Composer::Composer(Document document, const LoadOptions& options, Diagnostics& diagnostics)
    : plan_(std::make_unique<CompositionPlan>()),
      sections_(options.sections),
      linked_plugins_(options.linked_plugins),
      plugin_folders_(options.plugin_folders),
      diagnostics_(diagnostics) {
  plan_->document = std::move(document);
}

std::size_t Composer::failures() const {
  for (const auto& items = diagnostics_.items(); seen_ < items.size(); ++seen_)
    if (items[seen_].severity == Severity::error) ++errors_;
  return errors_ + silent_failures_;
}

void Composer::refuse(const ComponentError& refusal, const Reader& at) {
  if (refusal.is_data_error())
    diagnostics_.error(refusal.code(), Origin{refusal.file(), refusal.line(), 0}, at.pointer(), refusal.what());
  else
    place(at.pointer() + refusal.pointer()).error("B030", refusal.what());
}

void Composer::keep(Findings findings, const Reader& at) {
  for (const auto& note : findings.notes) diagnostics_.warning("B032", at.key_origin(), at.pointer(), note);
  if (!findings.figures.empty()) plan_->found.push_back({at.pointer(), std::move(findings.figures)});
}

Component Composer::read_component(Role role, const Reader& at, const std::vector<std::string>& reserved,
                                   FilterComposer* filter) {
  Component component{at, at.key(), failures()};
  if (!at.is_object("a component")) return component;
  if (!at.require("type", at.key(), std::string("a ") + role_name(role))) return component;
  if (const auto type = at["type"].text())
    component.type = plan_->catalog.want(role, *type, at["type"].origin(), at["type"].pointer(), diagnostics_);
  if (!component.type) return component;
  used_.emplace(component.type->plugin, component.type);
  const ComponentSpec& spec = component.spec();
  component.fields_bound.assign(spec.fields.size(), false);
  if (filter) filter->bind_ports(component);
  PortUnits port_units;
  for (const PortBinding& binding : component.ports) {
    if (binding.components.empty()) continue;
    const std::string& text = binding.components.front().unit;
    const auto unit = parse_unit(text);
    const bool is_uniform = std::ranges::all_of(binding.components, [&](const auto& c) { return c.unit == text; });
    if (unit && is_uniform) port_units.emplace(binding.name, PortMeasure{unit->dimension, binding.dof});
  }
  auto keys = reserved;
  if (role == Role::process_model && !spec.inputs.empty()) keys.push_back("inputs");
  component.parameters = at.parameters(spec.parameters, spec.type, keys, port_units);
  if (filter) filter->find_driving_rates(component);
  return component;
}

void Composer::check_section_keys(const Reader& at, std::vector<std::string> own, const std::string& what) {
  const std::vector<std::string> kernels = own;
  RenamedKeys renamed;
  for (const auto& section : sections_) {
    std::ranges::move(at.pointer().empty() ? section->keys() : section->filter_keys(), std::back_inserter(own));
    std::ranges::copy_if(section->renamed_keys(), std::back_inserter(renamed),
                         [&](const auto& names) { return index_of(own, names.second) >= 0; });
  }
  // Without readers the program may share its config with one that has some: only what looks misspelt is wrong.
  if (sections_.empty())
    for (const Reader& member : at.children())
      if (closest(member.key(), kernels).empty()) own.push_back(member.key());
  at.check_keys(own, what, renamed);
}

// The config's keys that the kernel reads; the composition is known by what stands under them.
namespace {

constexpr std::size_t most_members = 1000;

bool is_small(const Reader& section) {
  const std::size_t count = section.is_object() ? config::JsonOf::at(section).size() : 0;
  if (count > most_members)
    section.key_error(config::too_large, "'" + section.key() + "' has " + std::to_string(count) +
                                             " members; it may have " + std::to_string(most_members));
  return count <= most_members;
}

}  // namespace

bool Composer::are_sections_small() const {
  bool are_small = true;
  for (const char* name : {"sources", "transforms", "filters", "sinks"}) are_small &= is_small(place("")[name]);
  if (!are_small) return false;
  for (const Reader& filter : place("/filters").children())
    for (const char* name : {"blocks", "derived", "process", "measurements"}) are_small &= is_small(filter[name]);
  return are_small;
}

const std::vector<std::string> own_keys = {"binnacle", "title",   "description", "plugins", "vars",
                                           "origin",   "sources", "transforms",  "filters", "sinks"};

void Composer::read_head() {
  check_section_keys(place(""), own_keys, "the config");
  const Reader version = place("/binnacle");
  if (!version)
    place("").key_error("B028", "the config does not begin with \"binnacle\": 1 (the version of its format)");
  else if (!config::JsonOf::at(version).is_number_integer() || config::JsonOf::at(version).get<std::int64_t>() != 1)
    version.error("B028", "this program reads configs of version 1; found " + version.shown());
  place("/origin").value(parameter::origin());  // right, even where nothing uses it
  plan_->title = place("/title").text().value_or("");
}

bool Composer::load_plugins() {
  std::vector<PluginPath> paths;
  for (const Reader& plugin : place("/plugins").elements("'plugins'"))
    if (const auto path = plugin.path()) paths.push_back({*path, plugin.origin(), plugin.pointer()});
  Diagnostics found;
  for (const auto& plugin : linked_plugins_) plan_->catalog.add(plugin, found);
  plan_->catalog.load_search_path(paths, found, plugin_folders_, Catalog::Loading::when_wanted);
  diagnostics_.merge(found);
  return !found.has_errors();
}

void Composer::for_each_input(const VisitInput& visit_all) const {
  const CompositionPlan& plan = *plan_;
  const auto visit = [&](const Node& node, int channel, const std::string& pointer) {
    if (channel >= 0) visit_all(node, channel, pointer);
  };
  const auto visit_stages = [&](Node::Kind kind, const auto& stages) {
    for (int i = 0; i < count_of(stages); ++i)
      for (const auto& input : stages[as_size(i)].inputs) visit({kind, i}, input.channel, stages[as_size(i)].pointer);
  };
  visit_stages(Node::Kind::transform, plan.transforms);
  visit_stages(Node::Kind::sink, plan.sinks);
  for (int i = 0; i < count_of(plan.filters); ++i) {
    const auto& filter = plan.filters[as_size(i)];
    const Node node{Node::Kind::filter, i};
    const auto visit_auxiliary = [&](const auto& model) {
      for (const int index : model.auxiliary.channels)
        if (index >= 0) visit(node, filter.auxiliary[as_size(index)].channel, model.pointer);
    };
    for (const auto& process : filter.processes) {
      if (process.uses_input) visit(node, filter.input_channel, process.pointer);
      visit_auxiliary(process);
    }
    for (const auto& measurement : filter.measurements) {
      visit(node, measurement.channel, measurement.pointer);
      std::ranges::for_each(measurement.parts, visit_auxiliary);
    }
    for (const auto& block : filter.blocks)
      for (const InitialPlan* from : {&block.initial, block.again ? &*block.again : nullptr})
        if (from && from->channel >= 0)
          visit(node, filter.initial[as_size(from->channel)].channel, block.pointer + "/init");
  }
}

// Transforms and filters feed each other through channels; at one instant they work in this order.
void Composer::order_nodes() {
  struct Work {
    Node node;
    std::string pointer;
    std::vector<int> out, in = {};

    bool waits_for(const Work& other) const {
      return std::ranges::any_of(in, [&](int channel) { return index_of(other.out, channel) >= 0; });
    }
  };
  std::vector<Work> open;
  for (const auto& transform : plan_->transforms)
    open.push_back({{Node::Kind::transform, count_of(open)}, transform.pointer, transform.channels});
  for (int i = 0; i < count_of(plan_->filters); ++i) {
    const auto& filter = plan_->filters[as_size(i)];
    open.push_back({{Node::Kind::filter, i}, filter.pointer, filter.further_channels});
    open.back().out.push_back(filter.output_channel);
    if (filter.settled_channel >= 0) open.back().out.push_back(filter.settled_channel);
  }
  for_each_input([&](const Node& node, int channel, const std::string&) {
    const int index = index_of(open, node, &Work::node);
    if (index >= 0) open[as_size(index)].in.push_back(channel);
  });
  while (!open.empty()) {
    const auto next = std::ranges::find_if(open, [&](const Work& candidate) {
      return std::ranges::none_of(open, [&](const Work& other) { return candidate.waits_for(other); });
    });
    if (next == open.end()) {
      std::vector<std::string> names;
      for (const auto& work : open) names.push_back(work.pointer);
      return place(names.front()).error("B023", "these depend on each other in a cycle: " + listed(names));
    }
    plan_->nodes.push_back(next->node);
    open.erase(next);
  }
  for (int i = 0; i < count_of(plan_->sinks); ++i) plan_->nodes.push_back({Node::Kind::sink, i});
}

void Composer::lay_out() {
  Layout& layout = plan_->layout;
  for (auto& source : plan_->sources) {
    source.memory = layout.add<std::byte>(source.object->declaration().memory_bytes);
    source.head = layout.add<SourceHead>(1);
    for (const int channel : source.channels)
      source.slots.push_back(layout.add<double>(plan_->channels[as_size(channel)].doubles()));
  }
  for (auto& transform : plan_->transforms)
    transform.memory = layout.add<std::byte>(transform.object->declaration().memory_bytes);
  for (auto& filter : plan_->filters) {
    const auto n = as_size(filter.n);
    filter.head = layout.add<TimeHead>(1);
    filter.health = layout.add<Health>(1);
    filter.state = layout.add<double>(as_size(filter.stored_size));
    filter.covariance = layout.add<double>(covariance_doubles(filter.covariance_kind, filter.n));
    filter.initial_variances = layout.add<double>(n);
    filter.stationary_variances = layout.add<double>(n);
    for (auto& process : filter.processes)
      process.memory = layout.add<std::byte>(process.model->declaration().memory_bytes);
    for (auto& measurement : filter.measurements) {
      measurement.tally = layout.add<Tally>(1);
      measurement.nis = layout.add<NisMonitor>(1);
      measurement.variances = layout.add<double>(measurement.columns.size());
      const std::size_t further = measurement.gate_unit == GateUnit::sample ? 0 : 32;
      measurement.rows = layout.add<RowMonitor>(2 * as_size(measurement.max_rows) + further);
      const std::size_t begin = layout.size();
      for (auto& part : measurement.parts) part.memory = layout.add<std::byte>(part.model->declaration().memory_bytes);
      measurement.memory = {begin, layout.size() - begin};
      if (measurement.noise)
        measurement.noise_memory = layout.add<std::byte>(measurement.noise->declaration().memory_bytes);
      filter.queue_doubles = std::max(filter.queue_doubles, plan_->channels[as_size(measurement.channel)].doubles());
    }
    for (auto* list : {&filter.initial, &filter.auxiliary})
      for (auto& latest : *list) {
        latest.data = layout.add<double>(plan_->channels[as_size(latest.channel)].doubles());
        latest.head = layout.add<SampleHead>(1);
      }
    constexpr std::size_t most_queued = 64;
    const auto group = as_size(filter.samples_per_step) + 1;
    filter.pending = layout.add<PendingInput>(group);
    filter.pending_fields = layout.add<double>(group * as_size(filter.input_fields));
    filter.last_input = layout.add<double>(as_size(filter.input_fields));
    filter.driving_rates = layout.add<double>(as_size(filter.input_fields));
    filter.queue = layout.add<QueueEntry>(most_queued);
    filter.queue_data = layout.add<double>(most_queued * filter.queue_doubles);
  }
}

void Composer::add_subscriber(int channel, const std::string& pointer) {
  auto& subscribers = plan_->channel_infos[as_size(channel)].subscribers;
  if (index_of(subscribers, pointer) < 0) subscribers.push_back(pointer);
}

void Composer::add_subscribers() {
  for_each_input([&](const Node&, int channel, const std::string& pointer) { add_subscriber(channel, pointer); });
}

// A source or transform none of whose channels has a subscriber works for nothing: most likely a name is wrong somewhere.
void Composer::check_subscribers() {
  const auto check = [&](const auto& component) {
    const bool is_heard = std::ranges::any_of(component.channels, [&](int channel) {
      return !plan_->channel_infos[as_size(channel)].subscribers.empty();
    });
    if (!is_heard)
      diagnostics_.warning("B031", place(component.pointer).key_origin(), component.pointer,
                           "nothing subscribes to '" + component.name + "'");
  };
  std::ranges::for_each(plan_->sources, check);
  std::ranges::for_each(plan_->transforms, check);
}

std::unique_ptr<CompositionPlan> Composer::compose() {
  read_head();
  if (!are_sections_small() || !load_plugins()) return nullptr;
  add_sources();
  const Reader filters = place("/filters");
  if (!filters) place("").key_error("B010", "the config has no 'filters'; there is nothing to run");
  for (const Reader& filter : filters.members("'filters'"))
    if (filter.is_object("a filter")) filters_.emplace_back(*this, filter);
  add_transforms();
  for (auto& filter : filters_) filter.finish();
  bool is_complete = !diagnostics_.has_errors();
  for (auto& filter : filters_) {
    is_complete = is_complete && filter.is_complete;
    filter.describe();
    plan_->filter_infos.push_back(std::move(filter.info));
    plan_->filters.push_back(std::move(filter.plan));
  }
  for (const auto& channel : plan_->channels)
    plan_->channel_infos.push_back({channel.name, &channel.declaration, channel.position, channel.pointer});
  add_sinks();
  if (is_complete && !diagnostics_.has_errors()) add_subscribers();
  CompositionDraft draft(*this);
  for (const auto& section : sections_) plan_->sections.push_back(section->read(draft));
  if (is_complete && !diagnostics_.has_errors()) order_nodes();
  if (!is_complete || diagnostics_.has_errors()) return nullptr;
  plan_history();
  lay_out();
  for (auto& info : plan_->filter_infos)
    if (info.history > 0) info.history_bytes = HistoryPlan::most_snapshots * plan_->layout.size();
  check_subscribers();

  base::Fnv1a hash(plan_->document.hash(own_keys));
  hash.add(BINNACLE_VERSION);
  const auto plugins = plan_->catalog.plugins();
  for (const auto& plugin : plugins) hash.add(plugin.name + "=" + plugin.version + ";");
  for (const auto& [name, type] : used_) hash.add(plugin::contents_of(*type, plugins));
  plan_->hash = hash.value();
  return std::move(plan_);
}

}  // namespace binnacle::internal::compose

namespace binnacle {

using namespace internal;

Reader CompositionDraft::at(const std::string& pointer) const { return composer_.place(pointer); }
bool CompositionDraft::has_errors() const { return composer_.diagnostics().has_errors(); }
const std::vector<FilterInfo>& CompositionDraft::filters() const { return composer_.plan().filter_infos; }
const std::vector<ChannelInfo>& CompositionDraft::channels() const { return composer_.plan().channel_infos; }
bool CompositionDraft::is_patched() const { return composer_.plan().document.is_patched(); }

int CompositionDraft::channel(const std::string& name, const Reader& at) const {
  return composer_.channel_named(name, at);
}

bool CompositionDraft::has_failed(std::string_view filter, std::string_view value) const {
  return std::ranges::any_of(composer_.filters(), [&](const compose::FilterComposer& composed) {
    return composed.at.key() == filter && composed.failed_values.contains(std::string(value));
  });
}

void CompositionDraft::subscribe(int channel, const std::string& pointer) {
  composer_.plan().subscriptions.push_back({channel, pointer});
  composer_.add_subscriber(channel, pointer);
}

namespace {

template <class Base>
std::vector<StageInfo<Base>> stage_infos(const auto& stages) {
  std::vector<StageInfo<Base>> infos;
  for (const auto& stage : stages) {
    // Named, since clang 14 makes no aggregate from emplace_back's arguments.
    auto& info = infos.emplace_back();
    static_cast<BoundInfo<Base>&>(info) = {stage.name, stage.type, stage.object};
    info.outputs = stage.channels;
    for (const auto& input : stage.inputs)
      if (input.channel >= 0) info.inputs.push_back(input.channel);
  }
  return infos;
}

[[noreturn]] void throw_errors(const Diagnostics& diagnostics) {
  // One wrong line in the config outweighs missing data; a plugin that cannot be loaded outweighs both.
  bool has_load = false, has_config = false;
  for (const auto& item : diagnostics.items()) {
    if (item.severity != Severity::error) continue;
    const bool is_load = item.code >= "B040" && item.code < "B060";
    const bool is_data = item.code >= "B060" && item.code < "B080";
    has_load = has_load || is_load;
    has_config = has_config || (!is_load && !is_data);
  }
  if (has_load) throw LoadError(diagnostics);
  if (has_config) throw ConfigError(diagnostics);
  throw DataError(diagnostics);
}

std::unique_ptr<compose::CompositionPlan> plan_of(config::Document document, const LoadOptions& options,
                                                  Diagnostics& diagnostics) {
  if (diagnostics.has_errors()) throw_errors(diagnostics);
  auto plan = compose::Composer(std::move(document), options, diagnostics).compose();
  if (!plan) throw_errors(diagnostics);
  return plan;
}

}  // namespace

std::shared_ptr<const Composition> Composition::load(const std::filesystem::path& config, const LoadOptions& options) {
  Diagnostics diagnostics;
  auto plan = plan_of(config::Document::load(config, options, diagnostics), options, diagnostics);
  return std::shared_ptr<const Composition>(new Composition(std::move(plan), diagnostics));
}

std::shared_ptr<const Composition> Composition::parse(std::string_view text, const std::filesystem::path& name,
                                                      const LoadOptions& options) {
  Diagnostics diagnostics;
  auto plan = plan_of(config::Document::load(name, options, diagnostics, text), options, diagnostics);
  return std::shared_ptr<const Composition>(new Composition(std::move(plan), diagnostics));
}

std::shared_ptr<const Composition> Composition::of(const Config& config, const LoadOptions& options) {
  Diagnostics diagnostics;
  auto plan = plan_of(*config.document_, options, diagnostics);
  return std::shared_ptr<const Composition>(new Composition(std::move(plan), diagnostics));
}

Composition::Composition(std::unique_ptr<compose::CompositionPlan> plan, Diagnostics warnings)
    : plan_(std::move(plan)), warnings_(std::move(warnings)) {}

Composition::~Composition() = default;
const std::string& Composition::title() const { return plan_->title; }
const std::vector<FilterInfo>& Composition::filters() const { return plan_->filter_infos; }
const std::vector<ChannelInfo>& Composition::channels() const { return plan_->channel_infos; }
const std::vector<FoundInfo>& Composition::found() const { return plan_->found; }
std::size_t Composition::arena_bytes() const { return plan_->layout.size(); }
const Catalog& Composition::catalog() const { return plan_->catalog; }
const Diagnostics& Composition::warnings() const { return warnings_; }
std::uint64_t Composition::hash() const { return plan_->hash; }
std::string Composition::config() const { return plan_->document.root().dump(); }
const std::vector<std::shared_ptr<const SectionData>>& Composition::sections() const { return plan_->sections; }

std::vector<StageInfo<Source>> Composition::sources() const { return stage_infos<Source>(plan_->sources); }
std::vector<StageInfo<Transform>> Composition::transforms() const { return stage_infos<Transform>(plan_->transforms); }

}  // namespace binnacle
