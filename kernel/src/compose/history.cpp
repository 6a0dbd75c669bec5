// SPDX-License-Identifier: Apache-2.0
// "latency" of a source, "history" of a filter, and what works in order of arrival or of time.
#include <algorithm>

#include "compose/composer.hpp"

namespace binnacle::internal::compose {

namespace {

constexpr const char* forms =
    "a time, {\"field\": NAME}, {\"uniform\": [FROM, TO]}, {\"normal\": {\"mean\": …, \"sigma\": …}}, "
    "{\"exponential\": MEAN} or {\"batch\": PERIOD}";

double read_time(const Reader& at) { return at.number(parameter::number("", "s").at_least(0)).value_or(0.0); }

void read_field(const Reader& at, const std::vector<ChannelDeclaration>& channels, LatencyPlan& latency) {
  const auto name = at.text();
  if (!name) return;
  latency.kind = LatencyPlan::Kind::field;
  for (const auto& channel : channels) {
    int position = 0, found = -1;
    for (const auto& field : channel.fields) {
      if (field.is_per_row) continue;
      if (field.name == *name) found = position;
      ++position;
    }
    if (found < 0)
      at.error("B021", "channel '" + channel.name + "' has no field '" + *name + "' for the latency" +
                           suggestion(*name, names_of(channel.fields)) + " (it has " +
                           listed(names_of(channel.fields)) + ")");
    latency.fields.push_back(found);
  }
}

void read_uniform(const Reader& at, LatencyPlan& latency) {
  const auto limits = at.elements("'uniform'");
  if (limits.size() != 2) return at.error("B006", "'uniform' takes two times, [FROM, TO]; found " + at.shown());
  latency.kind = LatencyPlan::Kind::uniform;
  latency.first = read_time(limits[0]);
  latency.second = read_time(limits[1]);
  if (latency.first > latency.second) at.error("B010", "'uniform' ends before it begins: " + at.shown());
}

}  // namespace

std::optional<LatencyPlan> read_latency(const Reader& at, const std::vector<ChannelDeclaration>& channels) {
  if (!at) return std::nullopt;
  LatencyPlan latency;
  if (!at.is_object()) {
    latency.first = read_time(at);
    return latency;
  }
  at.check_keys({"field", "uniform", "normal", "exponential", "batch"}, "'latency'");
  if (at.children().size() != 1) {
    at.error("B010", std::string("'latency' is ") + forms + "; found " + at.shown());
    return std::nullopt;
  }
  if (const Reader field = at["field"]) read_field(field, channels, latency);
  if (const Reader uniform = at["uniform"]) read_uniform(uniform, latency);
  if (const Reader normal = at["normal"]; normal && normal.is_object("'normal'")) {
    normal.check_keys({"mean", "sigma"}, "'normal'");
    latency.kind = LatencyPlan::Kind::normal;
    latency.first = read_time(normal["mean"]);
    latency.second = read_time(normal["sigma"]);
  }
  if (const Reader mean = at["exponential"]) {
    latency.kind = LatencyPlan::Kind::exponential;
    latency.first = read_time(mean);
  }
  if (const Reader period = at["batch"]) {
    latency.kind = LatencyPlan::Kind::batch;
    latency.first = period.number(parameter::number("", "s").at_least(1e-3).at_most(1e9)).value_or(1.0);
  }
  return latency;
}

void FilterComposer::read_history(const ChannelDeclaration& estimates) {
  const Reader history = at["history"];
  if (!history) return;
  const bool has_budget = history.is_object();
  if (has_budget) history.check_keys({"length", "steps"}, "'history'");
  if (has_budget && !history.require("length", "history", "how late a sample may be")) return;
  const auto length = (has_budget ? history["length"] : history).time(parameter::time("history").above(0));
  if (!length) return;
  // With 1 it could never catch up: each arrival brings an instant.
  if (has_budget && history["steps"])
    plan.history_steps = history["steps"].integer(parameter::integer("steps").at_least(2)).value_or(0);
  plan.history = *length;
  ChannelDeclaration settled = estimates;
  settled.name = "settled";
  plan.settled_channel = composer.add_channels(at, {settled}).front();
}

namespace {

/// Nodes of `all` from which a chain of transforms leads to one of `ends`, with these, in their order.
std::vector<Node> with_transforms_before(const CompositionPlan& plan, std::vector<Node> ends, std::vector<int> channels,
                                         const std::vector<std::pair<Node, int>>& inputs) {
  for (std::size_t done = 0; done < ends.size(); ++done)
    for (const auto& [node, channel] : inputs)
      if (node == ends[done]) channels.push_back(channel);
  for (std::size_t c = 0; c < channels.size(); ++c)
    for (int t = 0; t < count_of(plan.transforms); ++t) {
      const Node node{Node::Kind::transform, t};
      if (index_of(plan.transforms[as_size(t)].channels, channels[c]) < 0 || index_of(ends, node) >= 0) continue;
      ends.push_back(node);
      for (const auto& [other, channel] : inputs)
        if (other == node) channels.push_back(channel);
    }
  std::vector<Node> ordered;
  std::ranges::copy_if(plan.nodes, std::back_inserter(ordered),
                       [&](const Node& node) { return index_of(ends, node) >= 0; });
  return ordered;
}

/// Filters with history share their samples, and the work on these.
void add_budget(const FilterPlan& filter, HistoryPlan& history) {
  history.length = std::max(history.length, filter.history);
  if (filter.history_steps > 0) history.steps = std::min(history.steps, filter.history_steps);
}

}  // namespace

void Composer::plan_history() {
  HistoryPlan& history = plan_->history;
  std::vector<std::pair<Node, int>> inputs;
  for_each_input([&](const Node& node, int channel, const std::string&) { inputs.emplace_back(node, channel); });
  std::vector<Node> with, without, sinks;
  for (const Node& node : plan_->nodes) {
    const bool has_history = node.kind == Node::Kind::filter && plan_->filters[as_size(node.index)].history > 0;
    if (has_history) add_budget(plan_->filters[as_size(node.index)], history);
    if (has_history) with.push_back(node);
    if (!has_history && node.kind != Node::Kind::transform) without.push_back(node);
  }
  if (with.empty()) return;
  std::vector<int> subscribed;
  for (const auto& subscription : plan_->subscriptions) subscribed.push_back(subscription.channel);
  history.nodes = with_transforms_before(*plan_, with, {}, inputs);
  history.settled_nodes = with_transforms_before(*plan_, with, subscribed, inputs);
  history.arrival_nodes = with_transforms_before(*plan_, without, subscribed, inputs);
  std::ranges::copy_if(plan_->nodes, std::back_inserter(history.arrival_nodes),
                       [&](const Node& node) { return index_of(with, node) >= 0; });
  std::ranges::sort(history.arrival_nodes, {}, [&](const Node& node) { return index_of(plan_->nodes, node); });
  history.is_root.assign(plan_->channels.size(), false);
  for (const auto& [node, channel] : inputs)
    if (index_of(history.settled_nodes, node) >= 0) history.is_root[as_size(channel)] = true;
  for (const int channel : subscribed) history.is_root[as_size(channel)] = true;
  for (const Node& node : history.settled_nodes) {
    if (node.kind == Node::Kind::transform)
      for (const int channel : plan_->transforms[as_size(node.index)].channels)
        history.is_root[as_size(channel)] = false;
    else
      history.is_root[as_size(plan_->filters[as_size(node.index)].settled_channel)] = false;
  }
}

}  // namespace binnacle::internal::compose
