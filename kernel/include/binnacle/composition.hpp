// SPDX-License-Identifier: Apache-2.0
// Composition: a checked config, ready to run any number of times.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/config.hpp"
#include "binnacle/declaration.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/sample.hpp"

namespace binnacle {

namespace internal::compose {
struct CompositionPlan;
}
class Catalog;        // binnacle/catalog.hpp
class ComponentType;  // binnacle/catalog.hpp
class DerivedBlock;
class MeasurementModel;
class NoiseEstimator;
class ProcessModel;
class SectionData;  // binnacle/section.hpp
class Source;
class StateBlock;
struct StateBlockDeclaration;
class Transform;

/// A component as it is bound. It keeps its plugin loaded.
template <class Base>
struct BoundInfo {
  std::string name;
  const ComponentType* type = nullptr;  // lives as long as the composition; null: there is none
  std::shared_ptr<const Base> object;
  std::vector<int> ports = {};  // what is plugged in: a block of the filter, or behind those a derived one; −1: open
};

/// Where a block lies in a filter's stored state and in its covariance.
struct BlockInfo {
  std::string name;
  std::string type;
  std::shared_ptr<const StateBlock> block;
  const StateBlockDeclaration* declaration = nullptr;
  int stored_offset = 0;
  int first_row = 0;             // of P
  std::vector<int> active;       // error components with a row in P, in order
  std::vector<std::string> use;  // per error component: "estimated", "considered", "frozen"
  std::vector<double> initial;   // stored value at the start, where the config gives it
};

/// Rows of a measurement that are of one kind: "velocity" of a stack, "range" of a model with two kinds of rows.
struct RowGroupInfo {
  std::string name;
  std::string unit;
  std::string kind = {};  // the model's own name for such rows; empty where it declares no group
  int like = -1;  // rows are the error components of this block of the filter, or of one of its kind; −1: of none
};

/// The χ² gate of a measurement, against outliers.
struct GateInfo {
  double probability = 0;  // 0: no gate
  std::string by;          // what it refuses: "sample", "row", "key"
  double nis_limit = 0;    // of a row, or of a whole sample with all of its rows
};

/// How its samples correct the state.
struct UpdateInfo {
  std::string type = "ekf";  // or "iterated", "unscented"
  int max = 0;               // of an iterated one: linearizations
  double tolerance = 0;      // and the last step, in sigma
};

/// A measurement of a filter: its channel, models, noise estimator, gate and update.
struct MeasurementInfo {
  std::string name;
  int channel = -1;
  int max_rows = 0;
  std::vector<BoundInfo<MeasurementModel>> parts;  // of its stack; or one, of its own name
  std::vector<RowGroupInfo> groups;                // counted through its parts, as UpdateRecord::row_groups gives them
  std::vector<int> blocks;                         // that its H has columns of, in the filter's order
  BoundInfo<NoiseEstimator> noise;                 // null where it has none
  bool recovers = false;
  bool is_watched = true;  // not excepted from "trust"
  GateInfo gate;
  UpdateInfo update;
};

/// A process model of a filter.
struct ProcessInfo : BoundInfo<ProcessModel> {
  int discretized_with = -1;  // a number in common with models which the kernel discretizes together; −1: by itself
};

/// A channel of which a filter needs a sample before it starts.
struct InitialInfo {
  int channel = -1;
  Time max_age = 0;  // 0: any age
};

/// Of a filter with `history`: as they are known now, or as they are once no sample can change them any more.
enum class Estimates : unsigned char { live, settled };

/// A filter: its parts, the layout of its state and its P, and what its config sets.
struct FilterInfo {
  std::string name;
  int dof = 0;  // rows of P
  int stored_size = 0;
  std::vector<BlockInfo> blocks;
  std::vector<BoundInfo<DerivedBlock>> derived;  // in order of dependence
  std::vector<ProcessInfo> processes;
  std::vector<MeasurementInfo> measurements;
  int input_channel = -1;
  std::string covariance;          // the form of P: "joseph", "ud" or "square_root"
  Time history = 0;                // how late a sample may be and is still applied; 0: not at all
  std::int64_t history_steps = 0;  // instants that are worked on, at most, for each that arrives; 0: any number
  std::size_t history_bytes = 0;   // the most that snapshots of a session's live estimates take, for all filters
  std::vector<InitialInfo> starts_when;
  bool is_unscented = false;  // propagation by sigma points: Φ of its step log is a regression, and full
  // Blocks that are declared other than zero; `to` and `from` count the filter's blocks, not ports.
  std::vector<Coupling> transition;  // Φ over what has a row in P; a block without an entry stays as it is
  std::vector<Coupling> noise;       // Qd, both halves
};

/// A channel: what it carries, what emits it and what subscribes to it.
struct ChannelInfo {
  std::string name;
  const ChannelDeclaration* declaration = nullptr;
  std::vector<int> position = {};  // of each declared field among the per-epoch or the per-row fields of a sample
  std::string pointer = {};        // JSON pointer of what emits it
  std::vector<std::string> subscribers = {};  // their JSON pointers; known once all is composed
};

/// A source or transform and its channels.
template <class Base>
struct StageInfo : BoundInfo<Base> {
  std::vector<int> inputs, outputs;
};

/// What the component at the pointer found out while it was bound.
struct FoundInfo {
  std::string pointer;
  std::vector<Findings::Figure> figures;
};

/// Immutable; share it between threads. Holds the plugins' libraries for as long as it lives.
class Composition {
 public:
  /// Reads and checks a config. All errors are reported at once: ConfigError (exit status 3), LoadError (4) when plugins
  /// cannot be loaded, DataError (5) when nothing but a data file is wrong.
  static std::shared_ptr<const Composition> load(const std::filesystem::path& config, const LoadOptions& options = {});
  /// The same from text; relative paths in it start at the folder of `name`.
  static std::shared_ptr<const Composition> parse(std::string_view text, const std::filesystem::path& name,
                                                  const LoadOptions& options = {});
  /// The same of a config that is read already, with the same options.
  static std::shared_ptr<const Composition> of(const Config& config, const LoadOptions& options);
  ~Composition();

  const std::string& title() const;
  const std::vector<FilterInfo>& filters() const;
  const std::vector<ChannelInfo>& channels() const;
  std::vector<StageInfo<Source>> sources() const;
  /// In order of dependence.
  std::vector<StageInfo<Transform>> transforms() const;
  const std::vector<FoundInfo>& found() const;
  const Catalog& catalog() const;
  /// What is suspicious but no error: channels that nothing subscribes to (B031), notes of components (B032).
  const Diagnostics& warnings() const;
  /// Identifies the composition: config as resolved, plugins and their versions, this kernel's version.
  std::uint64_t hash() const;
  /// The config as resolved, JSON text: extends merged, variables and --set applied.
  std::string config() const;
  /// What LoadOptions::sections made of theirs, in their order; null where one made nothing.
  const std::vector<std::shared_ptr<const SectionData>>& sections() const;
  /// What all that a run keeps takes; a snapshot is a little more.
  std::size_t arena_bytes() const;

  const internal::compose::CompositionPlan& plan() const { return *plan_; }  // the kernel's own

 private:
  explicit Composition(std::unique_ptr<internal::compose::CompositionPlan> plan, Diagnostics warnings);

  std::unique_ptr<internal::compose::CompositionPlan> plan_;
  Diagnostics warnings_;
};

}  // namespace binnacle
