// SPDX-License-Identifier: Apache-2.0
// Everything a config has become once it is checked: immutable, shared by all runs.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/index.hpp"
#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"
#include "binnacle/source.hpp"
#include "config/document.hpp"
#include "filter/plan.hpp"

namespace binnacle {
class RunObserver;
}

namespace binnacle::internal::compose {

using namespace filter;
using config::Document;

struct SourceHead {
  SampleHead sample;
  std::int32_t status = 0;   // 0: must be asked; 1: a sample waits; 2: ended
  std::int32_t channel = 0;  // among the source's own
};

struct NodeInput {
  int channel = -1;  // −1: optional and left open
  FieldMap fields;
};

/// A source, transform or sink.
template <class Base>
struct StagePlan : Planned {
  const ComponentType* type = nullptr;
  std::shared_ptr<Base> object;
  std::vector<NodeInput> inputs;
  std::vector<int> channels;  // that it emits
  Place<std::byte> memory;
  std::string identity;  // equal where it emits the same (identity.hpp); empty: of nothing else
};

using TransformPlan = StagePlan<Transform>;
using SinkPlan = StagePlan<Sink>;

/// How long a sample is on its way, from its time to its arrival [s].
struct LatencyPlan {
  enum class Kind { fixed, field, uniform, normal, exponential, batch } kind = Kind::fixed;
  double first = 0, second = 0;  // the time; or the lower and upper limit, the mean and sigma, the mean, the period
  std::vector<int> fields;       // by own channel: among its per-epoch fields
};

/// A source is opened by the first run of a composition that has it, whichever thread that is, and stays open.
struct SourceOpening {
  std::once_flag once;
  Diagnostics warnings;
  std::unique_ptr<Reporter> reporter;  // for as long as the source lives
  RunObserver* observer = nullptr;     // of the run under way that has live sources
};

struct SourcePlan : StagePlan<Source> {
  std::shared_ptr<SourceOpening> opening = std::make_shared<SourceOpening>();
  std::optional<LatencyPlan> latency;
  std::vector<std::string> files;  // that its parameters name
  Place<SourceHead> head;
  std::vector<Place<double>> slots;  // per own channel
};

/// What works on an instant's samples, in order of dependence.
struct Node {
  enum class Kind { transform, filter, sink } kind = Kind::transform;
  int index = 0;

  bool operator==(const Node&) const = default;
};

/// What filters with history need: they and the transforms before them work on samples in order of time, again where one came
/// late; all else works on samples as they arrive.
struct HistoryPlan {
  /// Snapshots of the live estimates in one length of the history: a late sample costs at most 1/32 of it more steps than its
  /// age has.
  static constexpr int snapshots = 32;
  static constexpr std::int64_t unbounded = std::numeric_limits<std::int64_t>::max();
  static constexpr int most_snapshots = snapshots + 2;  // with the one before it
  Time length = 0;                                      // the longest of the filters'; 0: there is none
  std::int64_t steps = unbounded;                       // instants that one arrival may cost: the least of the filters'
  std::vector<Node> nodes;                              // filters with history, and transforms on the way to them
  std::vector<Node> settled_nodes;                      // and transforms on the way to what sections subscribe to
  std::vector<Node> arrival_nodes;  // all else; filters with history stand where what they emit is wanted
  std::vector<bool> is_root;        // by channel: what comes to settled_nodes from outside
};

/// A channel whose samples a section of the config wants to see in every run.
struct Subscription {
  int channel = -1;
  std::string pointer;  // of the subscriber
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
  HistoryPlan history;
  std::vector<FoundInfo> found;
  std::vector<Subscription> subscriptions;
  std::vector<FilterInfo> filter_infos;
  std::vector<ChannelInfo> channel_infos;
  std::vector<std::shared_ptr<const SectionData>> sections;
  Layout layout;
  std::uint64_t hash = 0;

  int channel(std::string_view name) const { return base::index_of(channels, name, &ChannelPlan::name); }
};

}  // namespace binnacle::internal::compose
