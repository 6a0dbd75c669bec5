// SPDX-License-Identifier: Apache-2.0
// Everything a config has become once it is checked: immutable, shared by all runs.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"
#include "binnacle/metric.hpp"
#include "binnacle/source.hpp"
#include "config/document.hpp"
#include "filter/plan.hpp"
#include "spec/check.hpp"

namespace binnacle {

struct SourceHead {
  Time t = no_time;
  Time t0 = no_time;
  std::int32_t status = 0;   // 0: must be asked; 1: a sample waits; 2: ended
  std::int32_t channel = 0;  // among the source's own
  std::int32_t rows = 0;
  std::int32_t has_covariance = 0;
};

struct SourcePlan {
  std::string name;
  std::string pointer;
  const ComponentType* type = nullptr;
  std::shared_ptr<Source> source;
  std::vector<int> channels;
  Place<std::byte> memory;
  Place<SourceHead> head;
  std::vector<Place<double>> slots;  // per own channel
};

struct NodeInput {
  int channel = -1;  // −1: optional and left open
  FieldMap fields;
};

struct TransformPlan {
  std::string name;
  std::string pointer;
  const ComponentType* type = nullptr;
  std::shared_ptr<Transform> transform;
  std::vector<NodeInput> inputs;
  std::vector<int> channels;
  Place<std::byte> memory;
};

struct SinkPlan {
  std::string name;
  std::string pointer;
  const ComponentType* type = nullptr;
  std::vector<NodeInput> inputs;
  std::shared_ptr<Sink> sink;
};

/// What works on an instant's samples, in order of dependence.
struct Node {
  enum class Kind { transform, filter, sink } kind = Kind::transform;
  int index = 0;
};

/// What a filter is scored against: a block's outputs on a channel, or what was withheld from a measurement.
struct ReferencePlan {
  int filter = 0;
  int block = -1;          // −1: withheld samples of `measurement`
  int implied_state = -1;  // ≥ 0: this implied state of the block, not the block
  int channel = -1;
  std::vector<int> fields;        // per output of the block: per-epoch field of the channel, −1: not told
  std::optional<double> invalid;  // a sample whose fields all have this value tells nothing
  int measurement = -1;
  std::string label;  // "truth", "withheld fix"
};

struct NamedWindow {
  std::string name;
  int filter = -1;  // −1: all
  TimeSpan span;
};

struct EvaluationPlan {
  std::vector<ReferencePlan> references;
  TimeSpan span{std::numeric_limits<Time>::min() / 4, std::numeric_limits<Time>::max() / 4, false, false};
  std::vector<NamedWindow> windows;
  std::vector<Metric> metrics;
  std::vector<UnknownMetric> unknown_metrics;
};

/// Sources are opened by the first run of a composition, whichever thread that is, and stay open.
struct SourceOpening {
  std::once_flag once;
  Diagnostics warnings;
};

/// What a component found out while it was bound.
struct FoundPlan {
  std::string pointer;
  std::vector<Findings::Figure> figures;
};

struct CompositionPlan {
  Document document;
  Catalog catalog;
  std::string title;
  std::vector<ChannelPlan> channels;
  std::vector<SourcePlan> sources;
  std::vector<TransformPlan> transforms;
  std::vector<FilterPlan> filters;
  std::vector<SinkPlan> sinks;
  std::vector<Node> nodes;
  std::vector<FoundPlan> found;
  EvaluationPlan evaluation;
  Time record_every = 0;
  Layout layout;
  std::uint64_t hash = 0;
  std::shared_ptr<SourceOpening> opening = std::make_shared<SourceOpening>();

  int channel(std::string_view name) const {
    for (std::size_t i = 0; i < channels.size(); ++i)
      if (channels[i].name == name) return static_cast<int>(i);
    return -1;
  }
};

}  // namespace binnacle
