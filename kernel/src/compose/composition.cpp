// SPDX-License-Identifier: Apache-2.0
// The order of composing: head, plugins, channels, filters, evaluation, arena; and what a Composition reports of itself.
#include "binnacle/composition.hpp"

#include <algorithm>

#include "base/hash.hpp"
#include "binnacle/version.hpp"
#include "compose/composer.hpp"

namespace binnacle::compose {

Composer::Composer(Document document, const LoadOptions& options, Diagnostics& diagnostics)
    : plan_(std::make_unique<CompositionPlan>()), sections_(options.sections), diagnostics_(diagnostics) {
  plan_->document = std::move(document);
}

void Composer::error(const std::string& code, const std::string& pointer, const std::string& message) {
  diagnostics_.error(code, document().origin(pointer), pointer, message);
}

void Composer::key_error(const std::string& code, const std::string& pointer, const std::string& message) {
  diagnostics_.error(code, document().key_origin(pointer), pointer, message);
}

std::size_t Composer::error_count() const {
  const auto& items = diagnostics_.items();
  return static_cast<std::size_t>(std::count_if(items.begin(), items.end(), [](const Diagnostic& item) {
    return item.severity == Severity::error;
  }));
}

void Composer::refuse(const ComponentError& refusal, const std::string& pointer) {
  if (refusal.is_data_error()) {
    diagnostics_.error(refusal.code(), Origin{refusal.file(), refusal.line(), 0}, pointer, refusal.what());
    return;
  }
  const std::string at_pointer = pointer + refusal.pointer();
  error("B030", at_pointer, refusal.what());
}

void Composer::keep(Findings findings, const std::string& pointer) {
  for (const auto& note : findings.notes) diagnostics_.warning("B032", document().key_origin(pointer), pointer, note);
  if (!findings.figures.empty()) plan_->found.push_back({pointer, std::move(findings.figures)});
}

const ComponentType* Composer::type_of(Role role, const std::string& pointer) {
  if (!object_at(document(), pointer, "a component", diagnostics_)) return nullptr;
  const std::string name = pointer.substr(pointer.rfind('/') + 1);
  if (!require_key(document(), pointer, "type", name, std::string("a ") + role_name(role), diagnostics_))
    return nullptr;
  const std::string type_pointer = join_pointer(pointer, "type");
  const auto type = read_string(document(), type_pointer, diagnostics_);
  if (!type) return nullptr;
  return plan_->catalog.find(role, *type, document().origin(type_pointer), type_pointer, diagnostics_);
}

Component Composer::read_component(Role role, const std::string& name, const std::string& pointer,
                                   const std::vector<std::string>& reserved, FilterBuild* build) {
  Component component{name, pointer, type_of(role, pointer)};
  if (!component.type) return component;
  const std::size_t errors = error_count();
  const ComponentSpec& spec = component.spec();
  component.fields_bound.assign(spec.fields.size(), false);
  const bool is_bound = !build || bind_ports(*build, component);
  const auto port_units = [&](std::string_view port) -> std::optional<PortMeasure> {
    for (const auto& binding : component.ports) {
      if (binding.name != port || !binding.bound || binding.components.empty()) continue;
      const auto unit = parse_unit(binding.components.front().unit);
      for (const auto& other : binding.components)
        if (other.unit != binding.components.front().unit) return std::nullopt;
      if (unit) return PortMeasure{unit->dimension, binding.dof};
    }
    return std::nullopt;
  };
  auto keys = reserved;
  if (role == Role::process_model && !spec.inputs.empty()) keys.push_back("inputs");
  component.parameters =
      check_parameters(spec.parameters, spec.type, document(), pointer, keys, port_units, diagnostics_);
  const bool has_rates = !build || find_driving_rates(*build, component);
  component.is_whole = is_bound && has_rates && error_count() == errors;
  return component;
}

// The config's keys that the kernel reads; the composition is known by what stands under them.
const std::vector<std::string> own_keys = {"binnacle", "title",      "description", "plugins", "vars",
                                           "sources",  "transforms", "filters",     "sinks"};

void Composer::read_head() {
  check_section_keys("", own_keys, "the config");
  const auto* version = at("/binnacle");
  if (!version)
    key_error("B028", "", "the config does not begin with \"binnacle\": 1 (the version of its format)");
  else if (!version->is_number_integer() || version->get<std::int64_t>() != 1)
    error("B028", "/binnacle", "this program reads configs of version 1; found " + abbreviated(*version));
  if (at("/title"))
    if (const auto title = read_string(document(), "/title", diagnostics_)) plan_->title = *title;
}

void Composer::load_plugins() {
  std::vector<PluginPath> paths;
  if (const auto* plugins = array_at(document(), "/plugins", "'plugins'", diagnostics_))
    for (std::size_t i = 0; i < plugins->size(); ++i) {
      const std::string pointer = join_pointer("/plugins", i);
      if (const auto path = read_path(document(), pointer, diagnostics_))
        paths.push_back({*path, document().origin(pointer), pointer});
    }
  Diagnostics found;
  plan_->catalog.load_search_path(paths, found);
  load_errors_ = found.has_errors();
  diagnostics_.merge(found);
}

// Transforms and filters feed each other through channels; at one instant they work in this order.
void Composer::order_nodes() {
  struct Work {
    Node node;
    std::vector<int> in, out;
    std::string pointer;
  };
  std::vector<Work> open;
  for (std::size_t i = 0; i < plan_->transforms.size(); ++i) {
    const auto& transform = plan_->transforms[i];
    Work work{{Node::Kind::transform, static_cast<int>(i)}, {}, transform.channels, transform.pointer};
    for (const auto& input : transform.inputs) work.in.push_back(input.channel);
    open.push_back(std::move(work));
  }
  for (std::size_t i = 0; i < plan_->filters.size(); ++i) {
    const auto& filter = plan_->filters[i];
    Work work{{Node::Kind::filter, static_cast<int>(i)},
              {filter.input_channel},
              {filter.output_channel},
              filter.pointer};
    for (const auto& measurement : filter.measurements) work.in.push_back(measurement.channel);
    for (const auto* list : {&filter.initial, &filter.auxiliary})
      for (const auto& latest : *list) work.in.push_back(latest.channel);
    open.push_back(std::move(work));
  }
  while (!open.empty()) {
    const auto next = std::find_if(open.begin(), open.end(), [&](const Work& candidate) {
      return std::none_of(candidate.in.begin(), candidate.in.end(), [&](int channel) {
        return channel >= 0 && std::any_of(open.begin(), open.end(), [&](const Work& other) {
                 return std::find(other.out.begin(), other.out.end(), channel) != other.out.end();
               });
      });
    });
    if (next == open.end()) {
      std::vector<std::string> names;
      for (const auto& work : open) names.push_back(work.pointer);
      error("B023", names.front(), "these feed each other: " + listed(names));
      return;
    }
    plan_->nodes.push_back(next->node);
    open.erase(next);
  }
  for (std::size_t i = 0; i < plan_->sinks.size(); ++i) plan_->nodes.push_back({Node::Kind::sink, static_cast<int>(i)});
}

void Composer::lay_out() {
  Layout& layout = plan_->layout;
  const auto latest = [&](LatestPlan& plan) {
    plan.data = layout.add<double>(plan_->channels[as_size(plan.channel)].doubles());
    plan.head = layout.add<SampleHead>(1);
  };
  for (auto& source : plan_->sources) {
    source.memory = layout.add<std::byte>(source.source->declaration().memory_bytes);
    source.head = layout.add<SourceHead>(1);
    for (const int channel : source.channels)
      source.slots.push_back(layout.add<double>(plan_->channels[as_size(channel)].doubles()));
  }
  for (auto& transform : plan_->transforms)
    transform.memory = layout.add<std::byte>(transform.transform->declaration().memory_bytes);
  for (auto& filter : plan_->filters) {
    const auto n = as_size(filter.n);
    filter.head = layout.add<TimeHead>(1);
    filter.health = layout.add<Health>(1);
    filter.state = layout.add<double>(as_size(filter.stored_size));
    filter.covariance = layout.add<double>(as_size(padded(filter.n)) * n);
    for (auto& process : filter.processes)
      process.memory = layout.add<std::byte>(process.model->declaration().memory_bytes);
    for (auto& measurement : filter.measurements) {
      measurement.tally = layout.add<Tally>(1);
      if (measurement.gate_unit != GateUnit::sample)
        measurement.left_out = layout.add<LeftOut>(2 * as_size(measurement.max_rows) + 32);
      const std::size_t begin = layout.size();
      for (auto& part : measurement.parts) part.memory = layout.add<std::byte>(part.model->declaration().memory_bytes);
      measurement.memory = {begin, layout.size() - begin};
      if (measurement.noise)
        measurement.noise_memory = layout.add<std::byte>(measurement.noise->declaration().memory_bytes);
      filter.queue_doubles = std::max(filter.queue_doubles, plan_->channels[as_size(measurement.channel)].doubles());
    }
    for (auto* list : {&filter.initial, &filter.auxiliary})
      for (auto& entry : *list) latest(entry);
    constexpr std::size_t most_queued = 64;
    const auto group = as_size(filter.samples_per_step) + 1;
    filter.pending = layout.add<PendingInput>(group);
    filter.pending_fields = layout.add<double>(group * as_size(filter.input_fields));
    filter.driving_rates = layout.add<double>(as_size(filter.input_fields));
    filter.queue = layout.add<QueueEntry>(most_queued);
    filter.queue_data = layout.add<double>(most_queued * filter.queue_doubles);
  }
}

// A source or transform none of whose channels has a subscriber works for nothing: most likely a name is wrong somewhere.
void Composer::warn_of_unheard() {
  const auto check = [&](const std::string& name, const std::string& pointer, const std::vector<int>& channels) {
    const bool is_heard = std::any_of(channels.begin(), channels.end(),
                                      [&](int channel) { return !plan_->subscribers[as_size(channel)].empty(); });
    if (!is_heard)
      diagnostics_.warning("B031", document().key_origin(pointer), pointer, "nothing subscribes to '" + name + "'");
  };
  for (const auto& source : plan_->sources) check(source.name, source.pointer, source.channels);
  for (const auto& transform : plan_->transforms) check(transform.name, transform.pointer, transform.channels);
}

std::unique_ptr<CompositionPlan> Composer::compose() {
  read_head();
  load_plugins();
  if (load_errors_) return nullptr;
  add_sources();
  begin_filters();
  add_transforms();
  finish_filters();
  bool is_complete = !diagnostics_.has_errors();
  for (auto& build : builds_) {
    is_complete = is_complete && build.is_complete;
    plan_->filters.push_back(std::move(build.plan));
  }
  add_sinks();
  read_sections();
  if (is_complete && !diagnostics_.has_errors()) order_nodes();
  if (!is_complete || diagnostics_.has_errors()) return nullptr;
  lay_out();
  plan_->subscribers = subscribers(*plan_);
  warn_of_unheard();

  base::Fnv1a hash(document().hash(own_keys));
  hash.add(BINNACLE_VERSION);
  for (const auto& plugin : plan_->catalog.plugins()) hash.add(plugin.name + "=" + plugin.version + ";");
  plan_->hash = hash.value();
  return std::move(plan_);
}

}  // namespace binnacle::compose

namespace binnacle {

namespace {

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

Composition::Composition(std::unique_ptr<compose::CompositionPlan> plan, Diagnostics warnings)
    : plan_(std::move(plan)),
      warnings_(std::move(warnings)),
      filters_(compose::filter_infos(*plan_)),
      channels_(compose::channel_infos(*plan_)) {}

Composition::~Composition() = default;
const std::string& Composition::title() const { return plan_->title; }
const std::vector<FilterInfo>& Composition::filters() const { return filters_; }
const std::vector<ChannelInfo>& Composition::channels() const { return channels_; }
const std::vector<FoundInfo>& Composition::found() const { return plan_->found; }
std::size_t Composition::arena_bytes() const { return plan_->layout.size(); }
const Catalog& Composition::catalog() const { return plan_->catalog; }
const Diagnostics& Composition::warnings() const { return warnings_; }
std::uint64_t Composition::hash() const { return plan_->hash; }
std::string Composition::config() const { return plan_->document.root().dump(); }
const std::vector<std::shared_ptr<const SectionData>>& Composition::sections() const { return plan_->sections; }

std::vector<StageInfo> Composition::sources() const {
  std::vector<StageInfo> infos;
  for (const auto& source : plan_->sources)
    infos.push_back({source.name, source.type->full_name(), {}, source.channels});
  return infos;
}

std::vector<StageInfo> Composition::transforms() const {
  std::vector<StageInfo> infos;
  for (const auto& transform : plan_->transforms) {
    infos.push_back({transform.name, transform.type->full_name(), {}, transform.channels});
    for (const auto& input : transform.inputs)
      if (input.channel >= 0) infos.back().inputs.push_back(input.channel);
  }
  return infos;
}

}  // namespace binnacle
