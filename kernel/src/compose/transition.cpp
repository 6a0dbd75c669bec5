// SPDX-License-Identifier: Apache-2.0
// The structure of Φ and Qd of a filter: which blocks models write, which the kernel discretizes or gathers, and the
// row groups that the covariance arithmetic runs over.
#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "compose/composer.hpp"

namespace binnacle::internal::compose {

namespace {

class TransitionBuilder {
 public:
  explicit TransitionBuilder(FilterComposer& filter) : filter_(filter), plan_(filter.plan) {}

  void run() {
    add_model_blocks();
    group_linear_models();
    find_what_is_kept();
    collect_contributions();
    plan_.transition.n = plan_.n;
    for (int block = 0; block < block_count(); ++block) add_rows(block);
    for (const Made& made : all_made(&ProcessDeclaration::noise, &ProcessPlan::first_noise, &VanLoanGroup::qd))
      add_noise(made);
    finish(plan_.transition);
    if (plan_.is_unscented) plan_regression();
    mark_runs();
    mark_corrected();
    for (const auto& [pattern, list] :
         {std::pair(&transition_pattern_, &filter_.info.transition), std::pair(&noise_pattern_, &filter_.info.noise)})
      for (const auto& [key, structure] : *pattern) list->push_back({key.first, key.second, structure});
  }

 private:
  using Couplings = std::vector<Coupling> ProcessDeclaration::*;
  using Terms = std::vector<GatherPlan::Term>;
  using Pattern = std::map<std::pair<int, int>, Structure>;  // of the blocks that are declared other than zero

  /// A block of Φ or Qd that models or the kernel make: by values, and its index in the table.
  struct Made {
    int to = 0, from = 0;
    int table = 0;
    Structure structure = Structure::dense;
  };

  int block_count() const { return count_of(plan_.blocks); }
  const BlockPlan& block(int index) const { return plan_.blocks[as_size(index)]; }
  int rows(int index) const { return count_of(block(index).active); }
  int dof(int value) const { return filter_.values[as_size(value)].dof; }
  ProcessPlan& process(int index) { return plan_.processes[as_size(index)]; }

  int add_block(std::vector<std::size_t>& table, int doubles) {
    table.push_back(filter_.reserve(as_size(doubles)));
    return count_of(table) - 1;
  }

  /// What a process declares of Φ (F) or of Qd (GQGᵀ).
  std::vector<Made> declared(const ProcessPlan& process, Couplings couplings, int first) const {
    std::vector<Made> all;
    for (const auto& coupling : process.model->declaration().*couplings)
      all.push_back(
          {process.ports[as_size(coupling.to)], process.ports[as_size(coupling.from)], first++, coupling.structure});
    return all;
  }

  std::vector<Made> all_made(Couplings couplings, int ProcessPlan::*first,
                             std::vector<VanLoanGroup::Block> VanLoanGroup::*discretized) const {
    std::vector<Made> all;
    for (const auto& process : plan_.processes)
      if (process.van_loan_group < 0)
        std::ranges::copy(declared(process, couplings, process.*first), std::back_inserter(all));
    for (const auto& group : plan_.van_loan)
      for (const auto& block : group.*discretized)
        all.push_back({value_at(group, block.row), value_at(group, block.column), block.table});
    return all;
  }

  static int value_at(const VanLoanGroup& group, int first) {
    for (const auto* parts : {&group.advanced, &group.read})
      for (const auto& part : *parts)
        if (part.first == first) return part.value;
    return -1;
  }

  void add_model_blocks() {
    const auto add = [&](const ProcessPlan& process, Couplings couplings, std::vector<std::size_t>& table) {
      const int first = count_of(table);
      for (const Made& made : declared(process, couplings, first))
        add_block(table, made.structure == Structure::diagonal ? dof(made.to) : dof(made.to) * dof(made.from));
      return first;
    };
    for (auto& process : plan_.processes) {
      process.first_transition = add(process, &ProcessDeclaration::transition, plan_.transition_blocks);
      process.first_noise = add(process, &ProcessDeclaration::noise, plan_.noise_blocks);
    }
  }

  // Linear models coupled through a port are discretized together; so is any that has no closed form of its own.
  void group_linear_models() {
    const int count = count_of(plan_.processes);
    std::vector<int> root(as_size(count));
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int i) {
      while (root[as_size(i)] != i) i = root[as_size(i)];
      return i;
    };
    const auto is_linear = [&](int i) { return process(i).model->declaration().has_continuous_form; };
    for (int i = 0; i < count; ++i) {
      if (!is_linear(i)) continue;
      for (const Made& made : declared(process(i), &ProcessDeclaration::transition, 0)) {
        if (!plan_.is_block(made.from)) continue;
        const int owner = block(made.from).process;
        if (owner >= 0 && owner != i && is_linear(owner)) root[as_size(find(i))] = find(owner);
      }
    }
    for (int r = 0; r < count; ++r) {
      std::vector<int> members;
      for (int i = 0; i < count; ++i)
        if (is_linear(i) && find(i) == r) members.push_back(i);
      if (members.empty()) continue;
      if (members.size() > 1 || !process(members[0]).model->declaration().has_closed_form) add_group(members);
    }
  }

  /// Rows for what the members advance, then columns for what else they read; by value, where each begins.
  std::map<int, int> number_columns(const std::vector<int>& members, VanLoanGroup& group) {
    std::map<int, int> first;
    const auto add = [&](int value, std::vector<VanLoanGroup::Part>& parts) {
      if (!first.try_emplace(value, group.columns).second) return;
      parts.push_back({value, group.columns, dof(value)});
      group.columns += dof(value);
    };
    for (const int member : members)
      for (int b = 0; b < block_count(); ++b)
        if (block(b).process == member) add(b, group.advanced);
    for (const int member : members)
      for (const Made& made : declared(process(member), &ProcessDeclaration::transition, 0)) add(made.from, group.read);
    return first;
  }

  /// The blocks of Φ and Qd that can be other than zero: what can reach what, over any number of couplings.
  void add_reachable(VanLoanGroup& group) {
    std::vector<VanLoanGroup::Part> parts = group.advanced;
    parts.insert(parts.end(), group.read.begin(), group.read.end());
    const auto n = parts.size();
    const auto part_at = [&](int first) { return as_size(index_of(parts, first, &VanLoanGroup::Part::first)); };
    std::vector<std::vector<bool>> reach(n, std::vector<bool>(n, false)), noise(n, std::vector<bool>(n, false));
    for (std::size_t i = 0; i < n; ++i) reach[i][i] = true;
    for (const auto& coupled : group.dynamics) reach[part_at(coupled.row)][part_at(coupled.column)] = true;
    for (const auto& noisy : group.noise) {
      const auto a = part_at(noisy.row), b = part_at(noisy.column);
      noise[a][b] = noise[b][a] = true;
    }
    for (std::size_t k = 0; k < n; ++k)
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j) reach[i][j] = reach[i][j] || (reach[i][k] && reach[k][j]);
    const auto is_noisy = [&](std::size_t i, std::size_t j) {
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b)
          if (reach[i][a] && noise[a][b] && reach[j][b]) return true;
      return false;
    };
    const auto add = [&](std::size_t i, std::size_t j, auto& blocks, std::vector<std::size_t>& table) {
      const auto& to = parts[i];
      const auto& from = parts[j];
      blocks.push_back({add_block(table, to.dof * from.dof), to.first, from.first, to.dof, from.dof});
    };
    for (std::size_t i = 0; i < group.advanced.size(); ++i)
      for (std::size_t j = 0; j < n; ++j)
        if (reach[i][j]) add(i, j, group.phi, plan_.transition_blocks);
    for (std::size_t i = 0; i < group.advanced.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        if (is_noisy(i, j)) add(i, j, group.qd, plan_.noise_blocks);
  }

  void add_group(const std::vector<int>& members) {
    VanLoanGroup group;
    const auto first = number_columns(members, group);
    for (const int member : members) {
      const auto add = [&](Couplings couplings, int table, std::vector<VanLoanGroup::Block>& blocks) {
        for (const Made& made : declared(process(member), couplings, table))
          blocks.push_back(
              {made.table, first.at(made.to), first.at(made.from), dof(made.to), dof(made.from), made.structure});
      };
      process(member).van_loan_group = count_of(plan_.van_loan);
      add(&ProcessDeclaration::transition, process(member).first_transition, group.dynamics);
      add(&ProcessDeclaration::noise, process(member).first_noise, group.noise);
    }
    add_reachable(group);
    group.work = filter_.reserve(van_loan_matrices * as_size(group.columns * group.columns));
    plan_.van_loan.push_back(std::move(group));
  }

  void find_what_is_kept() {
    using Kept = ProcessPlan::Kept;
    for (auto& process : plan_.processes) {
      const auto& declared = process.model->declaration();
      const bool sees_more = process.uses_input || !process.auxiliary.channels.empty() || declared.memory_bytes > 0;
      if (!declared.is_time_invariant || sees_more) continue;
      const bool is_at_rest = declared.is_at_rest && declared.transition.empty() && declared.noise.empty();
      const bool is_scaling =
          declared.has_continuous_form && std::ranges::all_of(declared.transition, [](const Coupling& coupling) {
            return coupling.to == coupling.from && coupling.structure == Structure::diagonal;
          });
      process.kept = process.van_loan_group < 0 && (is_at_rest || is_scaling) ? Kept::all : Kept::coefficients;
    }
    for (int group = 0; group < count_of(plan_.van_loan); ++group)
      plan_.van_loan[as_size(group)].is_kept = std::ranges::none_of(plan_.processes, [&](const ProcessPlan& process) {
        return process.van_loan_group == group && process.kept == Kept::nothing;
      });
  }

  void collect_contributions() {
    for (const Made& made :
         all_made(&ProcessDeclaration::transition, &ProcessPlan::first_transition, &VanLoanGroup::phi)) {
      if (plan_.is_block(made.from))
        contributions_[{made.to, made.from}].push_back({made.table, made.structure});
      else
        for (const auto& dependence : plan_.derived_at(made.from).dependences)
          contributions_[{made.to, dependence.block}].push_back(
              {made.table, made.structure, made.from, dependence.jacobian});
    }
    // A block that depends on others but not from itself still keeps itself.
    std::set<int> depends, kept;
    for (const auto& [key, terms] : contributions_) {
      depends.insert(key.first);
      if (key.first == key.second && std::ranges::any_of(terms, [](const auto& term) { return term.derived < 0; }))
        kept.insert(key.first);
    }
    for (const int to : depends)
      if (!kept.contains(to)) {
        const int source = add_block(plan_.transition_blocks, dof(to));
        for (int i = 0; i < dof(to); ++i) plan_.ones.push_back(plan_.transition_blocks[as_size(source)] + as_size(i));
        contributions_[{to, to}].push_back({source, Structure::diagonal});
      }
  }

  /// A block of Φ, its active rows and columns: the model's own if that will do, else gathered. (Qd is read where it was written.)
  Made ready(int to, int from, const Terms& terms, bool wants_dense) {
    const auto& own = terms.front();
    const bool is_own = terms.size() == 1 && own.derived < 0 && block(to).is_whole() && block(from).is_whole();
    if (is_own && !(wants_dense && own.structure == Structure::diagonal)) return {to, from, own.source, own.structure};
    const int index = add_block(plan_.transition_blocks, rows(to) * rows(from));
    plan_.gathers.push_back({to, from, terms, plan_.transition_blocks[as_size(index)]});
    return {to, from, index};
  }

  void note(Pattern& pattern, int to, int from, Structure structure) {
    const auto entry = pattern.try_emplace({to, from}, Structure::diagonal).first;
    if (structure == Structure::dense && (rows(to) > 1 || rows(from) > 1)) entry->second = Structure::dense;
  }

  void add_rows(int to) {
    std::vector<std::pair<int, const Terms*>> sources;
    for (const auto& [key, terms] : contributions_)
      if (key.first == to && rows(key.second) > 0) sources.emplace_back(key.second, &terms);
    if (rows(to) == 0 || sources.empty()) return;
    const bool is_alone = sources.size() == 1 && sources[0].first == to;
    std::vector<Made> blocks;
    for (const auto& [from, terms] : sources) {
      const bool wants_dense = !is_alone && rows(to) <= 3;
      blocks.push_back(ready(to, from, *terms, wants_dense));
      note(transition_pattern_, to, from, blocks.back().structure);
    }
    const int first_row = block(to).first;
    if (is_alone && blocks[0].structure == Structure::diagonal) {
      for (int r = 0; r < rows(to); ++r) plan_.transition.diagonals.push_back({first_row + r, blocks[0].table, r});
      return;
    }
    const bool has_diagonal =
        std::ranges::any_of(blocks, [](const Made& b) { return b.structure == Structure::diagonal; });
    const int group_rows = has_diagonal ? 1 : 3;
    for (int r = 0; r < rows(to); r += group_rows) {
      RowGroup& group = plan_.transition.groups.emplace_back();
      group.first_row = first_row + r;
      group.rows = std::min(group_rows, rows(to) - r);
      for (const auto& source : blocks) {
        const int first_column = block(source.from).first;
        if (source.structure == Structure::diagonal)
          group.columns.push_back({first_column + r, source.table, r});
        else
          for (int c = 0; c < rows(source.from); ++c)
            group.columns.push_back({first_column + c, source.table, r + c * rows(to)});
      }
    }
  }

  void add_noise(const Made& made) {
    const int to = made.to, from = made.from;
    if (rows(to) == 0 || rows(from) == 0) return;
    std::vector<int> columns;
    if (made.structure == Structure::dense)
      for (const int column : block(from).active) columns.push_back(column * dof(to));
    plan_.transition.noise.push_back({block(to).first, block(from).first, block(to).active, columns, made.table});
    note(noise_pattern_, to, from, made.structure);
    note(noise_pattern_, from, to, made.structure);
  }

  /// Φ and Qd of a regression on sigma points, in one n×n matrix each. What no model moves stays an identity.
  void plan_regression() {
    const int n = plan_.n;
    plan_.jacobians = std::exchange(plan_.transition, {});
    plan_.transition.n = n;
    plan_.regression = filter_.reserve(as_size(n) * as_size(n));
    plan_.regression_noise = filter_.reserve(as_size(n) * as_size(n));
    const auto add_part = [&](std::vector<std::size_t>& table, std::size_t matrix, int row, int column) {
      table.push_back(matrix + as_size(row) + as_size(column) * as_size(n));
      return count_of(table) - 1;
    };
    const int whole = add_part(plan_.transition_blocks, plan_.regression, 0, 0);
    std::vector<bool> is_moved;
    for (int b = 0; b < block_count(); ++b) {
      is_moved.push_back(std::ranges::any_of(contributions_, [&](const auto& entry) {
        return entry.first.first == b && rows(entry.first.second) > 0;
      }));
      for (int r = 0; is_moved.back() && r < rows(b); r += 3) {
        RowGroup& group = plan_.transition.groups.emplace_back();
        group.first_row = block(b).first + r;
        group.rows = std::min(3, rows(b) - r);
        for (int column = 0; column < n; ++column)
          group.columns.push_back({column, whole, group.first_row + column * n});
      }
    }
    for (int b = 0; b < block_count(); ++b)
      for (int a = b; a < block_count(); ++a) {
        const bool is_noisy = noise_pattern_.contains({a, b}) || (is_moved[as_size(a)] && is_moved[as_size(b)]);
        if (!is_noisy || rows(a) == 0 || rows(b) == 0) continue;
        const int part = add_part(plan_.noise_blocks, plan_.regression_noise, block(a).first, block(b).first);
        plan_.transition.noise.push_back({block(a).first, block(b).first, places(rows(a)), places(rows(b), n), part});
      }
    finish(plan_.transition);
  }

  /// Where the models' own blocks lie one behind the other, the arithmetic reads them where they are.
  void mark_runs() {
    for (auto& group : plan_.transition.groups) {
      const auto place = [&](const RowGroup::Column& column) {
        return plan_.transition_blocks[as_size(column.block)] + as_size(column.offset);
      };
      group.is_in_one_run = true;
      for (std::size_t c = 0; c < group.columns.size(); ++c)
        group.is_in_one_run &= place(group.columns[c]) == place(group.columns[0]) + c * as_size(group.rows);
    }
  }

  void mark_corrected() {
    std::vector<unsigned char> corrected(as_size(plan_.n), 1);
    for (const auto& block : plan_.blocks)
      for (std::size_t a = 0; a < block.active.size(); ++a)
        if (block.use[as_size(block.active[a])] == Use::considered) corrected[as_size(block.first) + a] = 0;
    if (std::ranges::find(corrected, 0) != corrected.end()) plan_.corrected = corrected;
  }

  FilterComposer& filter_;
  FilterPlan& plan_;
  Pattern transition_pattern_, noise_pattern_;
  std::map<std::pair<int, int>, Terms> contributions_;  // to the blocks (to, from) of Φ
};

}  // namespace

void plan_transition(FilterComposer& filter) { TransitionBuilder(filter).run(); }

}  // namespace binnacle::internal::compose
