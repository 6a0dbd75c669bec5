// SPDX-License-Identifier: Apache-2.0
// The structure of Φ and Qd of a filter: which blocks models write, which the kernel discretizes or gathers, and the
// row groups that the covariance arithmetic runs over.
#include <algorithm>
#include <map>
#include <numeric>

#include "compose/composer.hpp"

namespace binnacle::compose {

namespace {

/// A contribution to the block (to, from) of Φ.
struct Contribution {
  GatherPlan::Term term;
  bool is_direct = true;
};

class TransitionBuilder {
 public:
  explicit TransitionBuilder(FilterBuild& build) : build_(build), plan_(build.plan) {}

  void run() {
    add_model_blocks();
    group_linear_models();
    collect_contributions();
    plan_.transition.n = plan_.n;
    for (int block = 0; block < block_count(); ++block) add_rows(block);
    add_noise();
    finish(plan_.transition);
    mark_corrected();
  }

 private:
  int block_count() const { return static_cast<int>(plan_.blocks.size()); }
  const BlockPlan& block(int index) const { return plan_.blocks[as_size(index)]; }
  int dof(int value) const { return build_.values[as_size(value)].dof; }

  int add_block(std::vector<std::size_t>& table, std::size_t doubles) {
    table.push_back(build_.reserve(doubles));
    return static_cast<int>(table.size()) - 1;
  }

  void add_model_blocks() {
    const auto add = [&](const ProcessPlan& process, const std::vector<Coupling>& couplings,
                         std::vector<std::size_t>& table) {
      const int first = static_cast<int>(table.size());
      for (const auto& coupling : couplings) {
        const int to = dof(process.ports[as_size(coupling.to)]), from = dof(process.ports[as_size(coupling.from)]);
        add_block(table, as_size(coupling.structure == Structure::diagonal ? to : to * from));
      }
      return first;
    };
    for (auto& process : plan_.processes) {
      const auto& declaration = process.model->declaration();
      process.first_transition = add(process, declaration.transition, plan_.transition_blocks);
      process.first_noise = add(process, declaration.noise, plan_.noise_blocks);
    }
  }

  // Linear models coupled through a port are discretized together; so is any that has no closed form of its own.
  void group_linear_models() {
    const int count = static_cast<int>(plan_.processes.size());
    std::vector<int> root(as_size(count));
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int i) {
      while (root[as_size(i)] != i) i = root[as_size(i)];
      return i;
    };
    const auto is_linear = [&](int i) { return plan_.processes[as_size(i)].model->declaration().has_continuous_form; };
    for (int i = 0; i < count; ++i) {
      if (!is_linear(i)) continue;
      for (const auto& coupling : plan_.processes[as_size(i)].model->declaration().transition) {
        const int from = plan_.processes[as_size(i)].ports[as_size(coupling.from)];
        if (from < 0 || from >= block_count()) continue;
        const int owner = block(from).process;
        if (owner >= 0 && owner != i && is_linear(owner)) root[as_size(find(i))] = find(owner);
      }
    }
    for (int r = 0; r < count; ++r) {
      std::vector<int> members;
      for (int i = 0; i < count; ++i)
        if (is_linear(i) && find(i) == r) members.push_back(i);
      if (members.empty()) continue;
      if (members.size() == 1 && plan_.processes[as_size(members[0])].model->declaration().has_closed_form) continue;
      add_group(members);
    }
  }

  /// Rows for what the members advance, then columns for what else they read; by value, where each begins.
  std::map<int, int> number_columns(const std::vector<int>& members, VanLoanGroup& group) {
    std::map<int, int> first;
    for (const int member : members)
      for (int b = 0; b < block_count(); ++b)
        if (block(b).process == member) {
          first[b] = group.rows;
          group.advanced.push_back({b, group.rows, dof(b)});
          group.rows += dof(b);
        }
    group.columns = group.rows;
    for (const int member : members) {
      const auto& process = plan_.processes[as_size(member)];
      for (const auto& coupling : process.model->declaration().transition) {
        const int from = process.ports[as_size(coupling.from)];
        if (first.contains(from)) continue;
        first[from] = group.columns;
        group.read.push_back({from, group.columns, dof(from)});
        group.columns += dof(from);
      }
    }
    return first;
  }

  /// What the members write of F and GQGᵀ.
  void add_declared(const std::vector<int>& members, const std::map<int, int>& first, VanLoanGroup& group) {
    for (const int member : members) {
      const auto& process = plan_.processes[as_size(member)];
      const auto& declaration = process.model->declaration();
      const auto part = [&](int block, const Coupling& coupling) {
        const int to = process.ports[as_size(coupling.to)], from = process.ports[as_size(coupling.from)];
        return VanLoanGroup::Block{block, first.at(to), first.at(from), dof(to), dof(from), coupling.structure};
      };
      for (std::size_t k = 0; k < declaration.transition.size(); ++k)
        group.dynamics.push_back(part(process.first_transition + static_cast<int>(k), declaration.transition[k]));
      for (std::size_t k = 0; k < declaration.noise.size(); ++k)
        group.noise.push_back(part(process.first_noise + static_cast<int>(k), declaration.noise[k]));
    }
  }

  /// The blocks of Φ and Qd that can be other than zero: what can reach what, over any number of couplings.
  void add_reachable(VanLoanGroup& group) {
    std::vector<VanLoanGroup::Part> parts = group.advanced;
    parts.insert(parts.end(), group.read.begin(), group.read.end());
    const auto n = parts.size();
    const auto part_at = [&](int first) {
      std::size_t i = 0;
      while (i < n && parts[i].first != first) ++i;
      return i;
    };
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
    const auto block = [&](std::size_t i, std::size_t j, int index) {
      return VanLoanGroup::Block{index, parts[i].first, parts[j].first, parts[i].dof, parts[j].dof, Structure::dense};
    };
    const auto is_noisy = [&](std::size_t i, std::size_t j) {
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b)
          if (reach[i][a] && noise[a][b] && reach[j][b]) return true;
      return false;
    };
    const auto size = [&](std::size_t i, std::size_t j) { return as_size(parts[i].dof * parts[j].dof); };
    for (std::size_t i = 0; i < group.advanced.size(); ++i)
      for (std::size_t j = 0; j < n; ++j)
        if (reach[i][j]) group.phi.push_back(block(i, j, add_block(plan_.transition_blocks, size(i, j))));
    for (std::size_t i = 0; i < group.advanced.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        if (is_noisy(i, j)) group.qd.push_back(block(i, j, add_block(plan_.noise_blocks, size(i, j))));
  }

  void add_group(const std::vector<int>& members) {
    VanLoanGroup group;
    for (const int member : members) {
      auto& process = plan_.processes[as_size(member)];
      process.van_loan_group = static_cast<int>(plan_.van_loan.size());
    }
    add_declared(members, number_columns(members, group), group);
    add_reachable(group);
    group.work = build_.reserve(van_loan_matrices * as_size(group.columns * group.columns));
    plan_.van_loan.push_back(std::move(group));
  }

  static int value_at(const VanLoanGroup& group, int first) {
    for (const auto* parts : {&group.advanced, &group.read})
      for (const auto& part : *parts)
        if (part.first == first) return part.value;
    return -1;
  }

  void contribute(int to, int from_value, int source, Structure structure) {
    if (from_value < block_count()) {
      contributions_[{to, from_value}].push_back({{source, structure, -1, 0}, true});
      return;
    }
    for (const auto& dependence : plan_.derived[as_size(from_value - block_count())].dependences)
      contributions_[{to, dependence.block}].push_back({{source, structure, from_value, dependence.jacobian}, false});
  }

  void collect_contributions() {
    for (const auto& process : plan_.processes) {
      if (process.van_loan_group >= 0) continue;
      const auto& transition = process.model->declaration().transition;
      for (std::size_t k = 0; k < transition.size(); ++k)
        contribute(process.ports[as_size(transition[k].to)], process.ports[as_size(transition[k].from)],
                   process.first_transition + static_cast<int>(k), transition[k].structure);
    }
    for (const auto& group : plan_.van_loan) {
      for (const auto& phi : group.phi)
        contribute(value_at(group, phi.row), value_at(group, phi.column), phi.table, Structure::dense);
    }
    // A block that depends on others but not from itself still keeps itself.
    std::set<int> depends, kept;
    for (const auto& [key, terms] : contributions_) {
      depends.insert(key.first);
      if (key.first != key.second) continue;
      for (const auto& contribution : terms)
        if (contribution.is_direct) kept.insert(key.first);
    }
    for (const int to : depends)
      if (!kept.contains(to)) {
        const int source = add_block(plan_.transition_blocks, as_size(dof(to)));
        for (int i = 0; i < dof(to); ++i) plan_.ones.push_back(plan_.transition_blocks[as_size(source)] + as_size(i));
        contributions_[{to, to}].push_back({{source, Structure::diagonal, -1, 0}, true});
      }
  }

  /// Index in the table of a block with active rows and columns, gathered unless the model's own will do.
  struct Ready {
    int from = 0;
    int table = 0;
    int stride = 0;
    Structure structure = Structure::dense;
  };
  Ready ready(int to, int from, const std::vector<Contribution>& terms, bool wants_dense) {
    const bool is_single = terms.size() == 1 && terms[0].is_direct && block(to).is_whole() && block(from).is_whole();
    if (is_single && !(wants_dense && terms[0].term.structure == Structure::diagonal))
      return {from, terms[0].term.source, dof(to), terms[0].term.structure};
    std::vector<GatherPlan::Term> gathered;
    for (const auto& contribution : terms) gathered.push_back(contribution.term);
    const int table = gather(to, from, std::move(gathered), plan_.transition_blocks, plan_.gathers);
    return {from, table, static_cast<int>(block(to).active.size()), Structure::dense};
  }

  int gather(int to, int from, std::vector<GatherPlan::Term> terms, std::vector<std::size_t>& table,
             std::vector<GatherPlan>& gathers) {
    const int index = add_block(table, block(to).active.size() * block(from).active.size());
    gathers.push_back({to, from, std::move(terms), table[as_size(index)]});
    return index;
  }

  void add_rows(int to) {
    const auto& target = block(to);
    if (target.active.empty()) return;
    std::vector<std::pair<int, const std::vector<Contribution>*>> sources;
    for (const auto& [key, terms] : contributions_)
      if (key.first == to && !block(key.second).active.empty()) sources.emplace_back(key.second, &terms);
    if (sources.empty()) return;
    const int rows = static_cast<int>(target.active.size());
    const bool is_alone = sources.size() == 1 && sources[0].first == to;
    std::vector<Ready> blocks;
    for (const auto& [from, terms] : sources) blocks.push_back(ready(to, from, *terms, !is_alone && rows <= 3));

    if (is_alone && blocks[0].structure == Structure::diagonal) {
      for (int r = 0; r < rows; ++r) plan_.transition.diagonals.push_back({target.first + r, blocks[0].table, r});
      return;
    }
    const bool has_diagonal =
        std::any_of(blocks.begin(), blocks.end(), [](const Ready& b) { return b.structure == Structure::diagonal; });
    const int group_rows = has_diagonal ? 1 : 3;
    for (int r = 0; r < rows; r += group_rows) {
      RowGroup group;
      group.first_row = target.first + r;
      group.rows = std::min(group_rows, rows - r);
      for (const auto& source : blocks) {
        const int first_column = block(source.from).first;
        if (source.structure == Structure::diagonal) {
          group.columns.push_back({first_column + r, source.table, r});
          continue;
        }
        for (std::size_t c = 0; c < block(source.from).active.size(); ++c)
          group.columns.push_back(
              {first_column + static_cast<int>(c), source.table, r + static_cast<int>(c) * source.stride});
      }
      plan_.transition.groups.push_back(std::move(group));
    }
  }

  void add_noise_block(int to, int from, int source, Structure structure) {
    const auto& row_block = block(to);
    const auto& column_block = block(from);
    if (row_block.active.empty() || column_block.active.empty()) return;
    const int rows = static_cast<int>(row_block.active.size()), columns = static_cast<int>(column_block.active.size());
    TransitionPlan::Noise noise{row_block.first, column_block.first, rows, columns, 0, source};
    if (row_block.is_whole() && column_block.is_whole()) {
      noise.stride = structure == Structure::diagonal ? 0 : rows;
    } else {
      noise.block = gather(to, from, {{source, structure, -1, 0}}, plan_.noise_blocks, plan_.noise_gathers);
      noise.stride = rows;
    }
    plan_.transition.noise.push_back(noise);
  }

  void add_noise() {
    for (const auto& process : plan_.processes) {
      if (process.van_loan_group >= 0) continue;
      const auto& noise = process.model->declaration().noise;
      for (std::size_t k = 0; k < noise.size(); ++k)
        add_noise_block(process.ports[as_size(noise[k].to)], process.ports[as_size(noise[k].from)],
                        process.first_noise + static_cast<int>(k), noise[k].structure);
    }
    for (const auto& group : plan_.van_loan) {
      for (const auto& qd : group.qd)
        add_noise_block(value_at(group, qd.row), value_at(group, qd.column), qd.table, Structure::dense);
    }
  }

  void mark_corrected() {
    bool has_considered = false;
    std::vector<unsigned char> corrected(as_size(plan_.n), 1);
    for (const auto& block : plan_.blocks)
      for (std::size_t a = 0; a < block.active.size(); ++a)
        if (block.use[as_size(block.active[a])] == Use::considered) {
          corrected[as_size(block.first) + a] = 0;
          has_considered = true;
        }
    if (has_considered) plan_.corrected = corrected;
  }

  FilterBuild& build_;
  FilterPlan& plan_;
  std::map<std::pair<int, int>, std::vector<Contribution>> contributions_;
};

}  // namespace

void Composer::plan_transition(FilterBuild& build) { TransitionBuilder(build).run(); }

}  // namespace binnacle::compose
