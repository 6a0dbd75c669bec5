// SPDX-License-Identifier: Apache-2.0
// A composed filter as the engine runs it: immutable, shared by any number of runs. Names are gone from the hot path;
// everything is an index or an offset.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "base/index.hpp"
#include "binnacle/derived_block.hpp"
#include "binnacle/measurement_model.hpp"
#include "binnacle/noise_estimator.hpp"
#include "binnacle/process_model.hpp"
#include "binnacle/state_block.hpp"
#include "binnacle/step_log.hpp"
#include "filter/covariance_form.hpp"
#include "filter/monitor.hpp"

namespace binnacle::internal::filter {

using base::as_size;

/// Padding keeps what lay there before: two equal states would have snapshots that differ. A constant expression cannot read
/// it, so that a type with padding does not compile.
template <class T>
consteval bool has_no_padding() {
  int sum = 0;
  for (const unsigned char byte : std::bit_cast<std::array<unsigned char, sizeof(T)>>(T{})) sum += byte;
  return sum >= 0;
}

/// A place for `count` objects of T in an arena; the same in every arena of one composition.
template <class T>
struct Place {
  static_assert(std::is_trivially_copyable_v<T>, "a snapshot is a copy of bytes");
  std::size_t offset = 0;
  std::size_t count = 0;

  T* in(std::byte* arena) const { return reinterpret_cast<T*>(arena + offset); }
  const T* in(const std::byte* arena) const { return reinterpret_cast<const T*>(arena + offset); }
};

/// Lays places out one after the other.
class Layout {
 public:
  static constexpr std::size_t alignment = 64;  // a cache line: no strip of P lies across two

  template <class T>
  Place<T> add(std::size_t count) {
    static_assert(alignof(T) <= alignment);
    static_assert(has_no_padding<T>());
    const Place<T> place{size_, count};
    size_ += (count * sizeof(T) + alignment - 1) / alignment * alignment;
    return place;
  }
  std::size_t size() const { return size_; }

 private:
  std::size_t size_ = 0;
};

/// What is made of a part of the config: by its key and JSON pointer.
struct Planned {
  std::string name;
  std::string pointer;
};

/// A channel as its samples lie in memory: per-epoch fields, per-row fields, covariance.
struct ChannelPlan : Planned {  // the pointer is of what emits it; "" for a pushed channel
  ChannelDeclaration declaration;
  std::vector<int> position;  // of each declared field among the per-epoch or the per-row fields
  int epoch_fields = 0;
  int row_fields = 0;
  int covariance_dof = 0;

  std::size_t doubles() const {
    return as_size(epoch_fields + row_fields * declaration.max_rows + covariance_dof * covariance_dof);
  }
};

/// A sample but for its numbers, which lie where a ChannelPlan says. Lies in the arena.
struct SampleHead {
  Time t = no_time;  // no_time: there is no sample yet
  Time t0 = no_time;
  std::int32_t rows = 0;
  std::int32_t has_covariance = 0;
};

/// How a component's declared fields are read from a channel.
struct FieldMap {
  enum class Conversion : unsigned char { none, to_rate, to_increment };
  struct Item {
    int index = -1;  // among the channel's per-epoch (per-row) fields; −1: the channel lacks it
    Conversion conversion = Conversion::none;
    bool required = false;
    int declared = 0;  // index in the spec, for messages
  };
  std::vector<Item> epoch;
  std::vector<Item> row;

  std::size_t doubles(int max_rows) const { return epoch.size() + row.size() * as_size(max_rows); }
  /// Whether the per-epoch fields are the channel's first ones as they stand.
  bool is_as_it_stands() const {
    for (std::size_t i = 0; i < epoch.size(); ++i)
      if (epoch[i].index != static_cast<int>(i) || epoch[i].conversion != Conversion::none) return false;
    return true;
  }
};

/// Per-epoch fields of a channel as a component declared them, converted. dt: length that they belong to.
void convert(const FieldMap& map, const double* fields, double dt, double* converted);
/// A channel's sample as a component declared its fields; `numbers`, of FieldMap::doubles(), hold them.
SampleView convert(const FieldMap& map, const ChannelPlan& channel, const SampleView& sample, double* numbers);

/// A sample's numbers to `data`, of ChannelPlan::doubles(), and what else there is of it; and back.
SampleHead pack(const ChannelPlan& channel, const SampleView& sample, double* data);
SampleView unpack(const ChannelPlan& channel, const SampleHead& head, const double* data);

enum class Use : unsigned char { estimated, considered, frozen };

/// Where a block's first value comes from.
struct InitialPlan {
  std::vector<double> value;    // stored value, when given in the config
  int channel = -1;             // else: index among the filter's initial channels
  std::vector<int> fields;      // per output: which per-epoch field of that channel
  std::vector<int> covariance;  // per error component: which covariance component; empty: none
  std::vector<double> sigma;    // per error component; NaN: from the sample's covariance
};

struct BlockPlan : Planned {
  std::string type;
  std::shared_ptr<const StateBlock> block;
  std::vector<Use> use;     // per error component
  std::vector<int> active;  // error components with a place in P
  int first = 0;            // row of the first of them in P
  int stored_offset = 0;    // in the filter's stored state, doubles
  int stored_size = 0;
  int process = -1;
  bool holds_frozen = false;
  InitialPlan initial;
  std::optional<InitialPlan> again;  // where it starts anew from another place
  const InitialPlan& start(bool anew) const { return anew && again ? *again : initial; }

  const StateBlockDeclaration& declaration() const { return block->declaration(); }
  int dof() const { return static_cast<int>(use.size()); }
  int outputs() const { return static_cast<int>(declaration().outputs.size()); }
  bool is_whole() const { return static_cast<int>(active.size()) == dof(); }
  /// Its value in the stored state.
  VectorView in(double* x) const { return {x + stored_offset, stored_size}; }
  ConstVectorView in(const double* x) const { return {x + stored_offset, stored_size}; }
};

/// Values that models bind to: state blocks first, then derived blocks in order of dependence.
struct DerivedPlan : Planned {
  struct Dependence {
    int block = 0;
    std::size_t jacobian = 0;  // offset in the workspace: dof(derived) × dof(block), column-major
  };
  struct Read {
    int value = 0;             // index of the value read
    std::size_t jacobian = 0;  // offset in the workspace: dof × dof(value)
    int port = 0;
  };
  std::string type;
  std::shared_ptr<const DerivedBlock> derived;
  std::vector<int> ports;  // value index per port, −1 open
  std::vector<Read> reads;
  std::vector<Dependence> dependences;  // on state blocks, ascending
  std::vector<int> driving_rates;       // index of each in the input channel
  std::size_t value = 0;                // offset in the workspace

  int dof() const { return derived->declaration().dof(); }
};

/// The auxiliary channels of a model, per declared input.
struct AuxiliaryPlan {
  std::vector<int> channels;  // index among the filter's auxiliary channels; −1 open
  std::vector<FieldMap> fields;
};

struct ProcessPlan : Planned {
  std::string type;
  std::shared_ptr<const ProcessModel> model;
  std::vector<int> ports;  // value index per port, −1 open
  FieldMap fields;
  bool uses_input = false;
  AuxiliaryPlan auxiliary;
  Place<std::byte> memory;
  int first_transition = 0;  // of its blocks in the table of model-written Φ blocks
  int first_noise = 0;
  int van_loan_group = -1;  // ≥ 0: discretized by the kernel
  /// What holds for every step of one length: nothing; what it writes of Φ and Qd (F and GQGᵀ); or that it is x⁺ = Φ x
  /// besides, Φ diagonal, for which it need not be called.
  enum class Kept : unsigned char { nothing, coefficients, all };
  Kept kept = Kept::nothing;
};

/// A block of Φ that must be put together because a component is frozen or a port is derived:
/// target(active rows, active columns) = Σ block · chain.
struct GatherPlan {
  struct Term {
    int source = 0;  // index in the table of blocks
    Structure structure = Structure::dense;
    int derived = -1;       // the derived value in between; −1: none
    std::size_t chain = 0;  // its Jacobian to from_block in the workspace
  };
  int to_block = 0;
  int from_block = 0;
  std::vector<Term> terms;
  std::size_t target = 0;  // offset in the workspace: active(to) × active(from), column-major
};

/// Linear process models whose blocks are coupled: one F, one GQGᵀ, one matrix exponential.
///
/// Rows are the advanced blocks; the columns are those and, after them, blocks that the group only reads. What is read
/// from outside the group is held over the step, so its coupling is exact for a constant and of first order else.
struct VanLoanGroup {
  struct Part {
    int value = 0;  // state block or derived value
    int first = 0;  // row and column of the group's matrices
    int dof = 0;
  };
  struct Block {
    int table = 0;  // index in the filter's table of blocks
    int row = 0;
    int column = 0;
    int rows = 0;
    int columns = 0;
    Structure structure = Structure::dense;
  };
  std::vector<Part> advanced;
  std::vector<Part> read;
  std::vector<Block> dynamics;  // F as the models write it
  std::vector<Block> noise;     // GQGᵀ as the models write it
  std::vector<Block> phi;       // the discrete blocks that are made of them
  std::vector<Block> qd;
  int columns = 0;       // Σ dof of both
  std::size_t work = 0;  // offset in the workspace of van_loan_matrices
  bool is_kept = false;  // all its models are time-invariant: Φ and Qd hold for every step of one length
};

/// In the workspace of a group, columns × columns: F, Q, Phi, Qd, and four that discretize() works with.
inline constexpr std::size_t van_loan_matrices = 8;

struct PartPlan : Planned {
  /// Where a read's Jacobian goes in the compact H: straight, or through the Jacobian of a derived value.
  struct Target {
    int block = 0;
    int first_column = 0;
    bool is_direct = true;
    std::size_t chain = 0;  // offset in the workspace: dof(value) × dof(block)
  };
  struct Read {
    int value = 0;
    int dof = 0;
    std::size_t jacobian = 0;  // offset in the workspace: max_rows of the whole update × dof
    std::vector<Target> targets;
    int port = 0;
  };
  std::string type;
  std::shared_ptr<const MeasurementModel> model;
  std::vector<int> ports;
  std::vector<Read> reads;
  FieldMap fields;
  std::vector<int> driving_rates;
  AuxiliaryPlan auxiliary;
  Place<std::byte> memory;
};

/// What became of a measurement's samples. Lies in the arena.
struct Tally : SampleCounts {
  std::int64_t reached = 0;  // by the filter's time: offered less late and waiting
  Streak gated;              // in a row
  double nis_sum = 0;
  Time last_accepted = no_time;
  Time first_recovery = no_time, last_recovery = no_time;
  std::int64_t recoveries_in_vain = 0;           // in a row, each soon after the one before
  static constexpr double beyond_reason = 1000;  // sigma: no error that grew is so large
  std::int64_t unconfirmed = 0, absurd = 0, is_widened = 0;
  // Samples that repeat the one before to the bit, after others that did not.
  std::uint64_t fingerprint = 0;
  std::int64_t changes = 0;     // samples that did not
  Streak repeats;               // refused ones that did
  std::int64_t repeated = 0;    // gated samples that did
  std::int64_t believable = 0;  // gated in a row, without those
  // The longest time without a sample of use in which what it sees became much less certain.
  Time last_useful = no_time;
  Time longest_silence = 0, longest_silence_at = no_time;
  Time first_silence = 0, first_useful = no_time;  // up to the first
  char last_reason[96] = {};
};

/// What a gate tests: a whole sample, its rows one by one, or the rows of one key (a satellite's) together.
enum class GateUnit : unsigned char { sample, row, key };
inline constexpr const char* gate_unit_names[] = {"sample", "row", "key"};

/// How the samples of a measurement correct the state.
struct UpdatePlan {
  enum class Type : unsigned char { ekf, iterated, unscented };
  static constexpr const char* names[] = {"ekf", "iterated", "unscented"};
  /// A block that the measurement sees.
  struct Seen {
    int block = 0;
    int first_column = 0;  // of the compact H
  };
  Type type = Type::ekf;
  int most = 10;            // linearizations of an iterated one
  double tolerance = 1e-3;  // of its last step, in sigma
  std::vector<Seen> seen;
};

struct MeasurementPlan : Planned {
  struct Inflation {
    int row = 0;
    double variance = 0;
  };
  int channel = 0;  // index in the composition's channels
  std::vector<PartPlan> parts;
  std::vector<int> derived;  // values to evaluate, in order
  std::vector<int> columns;  // of P, one per column of the compact H
  int max_rows = 0;
  double gate = 0;  // probability; 0: no gate
  GateUnit gate_unit = GateUnit::sample;
  std::vector<double> gate_limit;  // χ² quantile by row count
  std::shared_ptr<const NoiseEstimator> noise;
  std::string noise_type;
  Place<std::byte> noise_memory;
  bool learn_from_gated = false;
  int recover_after = 5;                               // refusals in a row of one unit; 0: no recovery
  Time recover_against = 45 * nanoseconds_per_second;  // instead, where most of what comes passes
  std::vector<Inflation> inflations;                   // instead of the opening along what the rows see
  int withhold_every = 0;
  std::vector<TimeSpan> withheld;
  UpdatePlan update;
  Place<Tally> tally;
  Place<NisMonitor> nis;
  Place<double> variances;         // of its columns, when a sample was last of use
  Place<RowMonitor> rows;          // as many as it may have, and for keys that come and go a few more
  bool is_watched = true;          // its monitors count in the verdict
  std::vector<double> systematic;  // of each group: a mean that is no reason
  bool widens = false;             // R of rows that scatter by more than they claim
  Place<std::byte> memory;         // of its parts together
};

/// The limits of a filter's monitors, "trust" in the config. What is 0 is not looked at.
struct TrustPlan {
  double false_alarm = 1e-3;  // probability that the tests of innovations together fail a right filter, in ten minutes
  bool tests_nis = true, tests_bias = true, tests_correlation = true;
  std::int64_t after = 5;   // refusals in a row that are a lock-out, and samples without an accepted one
  double refused = 0.5;     // share of rows
  double nis = 25;          // NIS over its rows that is beyond all reason
  Time hole = 500'000'000;  // bridged
  Time frozen = 1 * nanoseconds_per_second;   // an input that repeats itself
  Time silent = 30 * nanoseconds_per_second;  // without a sample of use
};

/// A channel whose latest sample a filter keeps: for initial values, or as an auxiliary input.
struct LatestPlan {
  int channel = 0;
  Time max_age = 0;  // initial values only; 0: any age
  // Initial values only: whether the first start needs it, and whether a further one needs a new sample of it.
  bool is_of_start = false, is_of_restart = false;
  Place<double> data;  // as ChannelPlan lays it out
  Place<SampleHead> head;

  /// Not available before the first one.
  SampleView in(const std::byte* arena, const std::vector<ChannelPlan>& channels) const {
    return unpack(channels[as_size(channel)], *head.in(arena), data.in(arena));
  }
};

/// When a filter is. Lies in the arena.
struct TimeHead {
  Time t = no_time;      // the filter's time
  Time start = no_time;  // the first
  Time first_restart = no_time;
  Time last_start = no_time;
  Time restart_until = no_time;  // it starts anew if it can up to this time
  Time input_end = no_time;      // end of the newest input interval
  Time newest = no_time;         // of measurements' samples, and incomplete ones of the input
  std::int64_t steps = 0;
  std::int64_t gaps = 0;
  std::int32_t starts = 0;
  std::int32_t started = 0;  // and goes on
  std::int32_t pending = 0;  // input samples waiting
  std::int32_t queued = 0;
  std::int32_t driving_rates_known = 0;
  std::int32_t just_started = 0;  // the next input sample may begin before the filter's time
  std::int64_t bridged = 0;       // the last driving interval bridged a hole
  Time longest_hole = 0;          // that was bridged, and where it began
  Time longest_hole_at = no_time;
  Time stopped_by = 0;  // the last hole that was not, and where it began
  Time stopped_at = no_time;
  // Input samples that repeat the one before to the bit, after others that did not.
  std::int64_t changes = 0;  // samples that did not
  std::int64_t repeats = 0;  // in a row
  Time repeats_since = no_time;
  Time longest_repeat = 0;
  Time longest_repeat_at = no_time;
};

/// Whether it goes on. Lies in the arena.
struct Health {
  std::int32_t is_broken = 0;
  char diagnosis[252] = {};  // why it broke
  // What P was farthest from a covariance by, where it was looked at: the row, the share of its variance, and when.
  std::int32_t indefinite_row = -1;
  // The update that P had fewest digits for: its measurement, how many times its noise it saw, and when.
  std::int32_t unresolved_by = -1;
  double indefinite_share = 0;
  Time indefinite_at = no_time;
  double unresolved_ratio = 0;
  Time unresolved_at = no_time;
};

struct PendingInput {
  Time t0 = no_time;  // not yet consumed part
  Time t1 = no_time;
  Time whole_t0 = no_time;
  Time whole_t1 = no_time;
  double whole_dt = 0;       // length that the sample's numbers belong to
  std::int64_t bridges = 0;  // it bridges a hole
};

struct QueueEntry {
  SampleHead sample;
  std::int32_t measurement = 0;
  std::int32_t slot = 0;  // of its data
};

struct FilterPlan : Planned {
  std::vector<BlockPlan> blocks;
  std::vector<DerivedPlan> derived;
  std::vector<ProcessPlan> processes;
  std::vector<MeasurementPlan> measurements;
  std::vector<LatestPlan> initial;  // channels that initial values come from
  std::vector<LatestPlan> auxiliary;
  TrustPlan trust;
  Time longest_bridge = 0;  // over a hole; after a longer one the filter starts anew. 0: no limit

  int input_channel = -1;  // index in the composition's channels
  int input_fields = 0;
  std::vector<FieldKind> input_kinds;     // of its per-epoch fields
  std::vector<unsigned char> input_used;  // whether a process or the driving rates read it: then it must be finite
  int samples_per_step = 1;
  std::size_t queue_doubles = 0;           // per entry
  int output_channel = -1;                 // its estimates, in the composition's channels
  bool emits_input = false;                // after each step of its input too, not only after what was accepted
  std::vector<int> further_channels = {};  // of sections
  Time history = 0;                // how late a sample may be and is still applied where it belongs; 0: not at all
  std::int64_t history_steps = 0;  // instants that one arrival may cost for it; 0: any number
  int settled_channel = -1;        // its estimates once nothing can change them; of a filter with history

  int n = 0;  // rows of P
  int stored_size = 0;
  std::vector<int> process_derived;  // derived values that process models read, in order
  TransitionPlan transition;
  // Tables of blocks by their offset in the workspace: first what models write, in the order of the processes and their
  // declarations; then what the kernel makes of it. Everything else refers to blocks by index in these tables.
  std::vector<std::size_t> transition_blocks;
  std::vector<std::size_t> noise_blocks;
  std::vector<std::size_t> ones;    // elements of the workspace that are 1 for ever (identity blocks)
  std::vector<GatherPlan> gathers;  // for Φ, after the models and Van Loan
  std::vector<VanLoanGroup> van_loan;
  // "propagation": "unscented". Then `transition` is of the regression, whose Φ and Qd are n×n, and `jacobians` of what
  // the models write.
  bool is_unscented = false;
  TransitionPlan jacobians;
  std::size_t regression = 0;            // offset of that Φ in the workspace
  std::size_t regression_noise = 0;      // and of that Qd
  std::vector<unsigned char> corrected;  // per row of P; empty: all
  std::size_t workspace = 0;             // doubles
  int max_rows = 0;
  int max_columns = 0;

  Place<TimeHead> head;
  Place<Health> health;
  Place<double> state;
  CovarianceKind covariance_kind = CovarianceKind::joseph;
  Place<double> covariance;         // as the form keeps it
  Place<double> initial_variances;  // of the newest start
  // Of components that have one by themselves, by the first step after it; infinite else, not a number before.
  Place<double> stationary_variances;
  Place<PendingInput> pending;
  Place<double> pending_fields;
  Place<double> last_input;     // fields of the newest input sample
  Place<double> driving_rates;  // mean rates of the last driving interval, in the input channel's order
  Place<QueueEntry> queue;
  Place<double> queue_data;

  /// Φ and Qd as the models write them.
  const TransitionPlan& of_models() const { return is_unscented ? jacobians : transition; }
  /// Of a value that models bind to, by its index.
  bool is_block(int value) const { return value < static_cast<int>(blocks.size()); }
  const DerivedPlan& derived_at(int value) const { return derived[as_size(value) - blocks.size()]; }
  int dof(int value) const { return is_block(value) ? blocks[as_size(value)].dof() : derived_at(value).dof(); }
  /// Of the largest block, at least 1.
  int most_dof() const {
    int most = 1;
    for (const auto& block : blocks) most = std::max(most, block.dof());
    return most;
  }
};

}  // namespace binnacle::internal::filter
