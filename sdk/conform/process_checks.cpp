// SPDX-License-Identifier: Apache-2.0
// numbers.process: Φ against differences, Qd against its own halves, dt = 0, and a filter that believes them.
#include <cmath>
#include <numeric>

#include <Eigen/Eigenvalues>
#include <boost/math/distributions/chi_squared.hpp>
#include <unsupported/Eigen/MatrixFunctions>

#include "binnacle/legacy.hpp"
#include "binnacle/session.hpp"
#include "compare.hpp"

namespace binnacle::conform {

namespace {

constexpr double ordinary_dt = 0.01;
/// What a model may leave out of Φ: an effect this small in one step, between plausible errors.
constexpr double negligible = 1e-6;
/// How far Φ may be from differences, of the largest element of Φ − I in the block: models are truncated in dt.
constexpr double truncation = 0.02;

struct Subject {
  explicit Subject(Trial& trial) : composition(compose_example(trial)), process(trial, *composition) {
    memory.resize(declared().memory_bytes);
    process.part.model->start(memory.data());
  }
  const ProcessDeclaration& declared() const { return process.part.model->declaration(); }
  bool is_closed() const { return declared().has_closed_form; }
  Propagated call(const PortStates& ports, const ProcessInput& input) const {
    auto own = memory;
    return process.call(ports, input, own.data(), unwritten());
  }
  bool is_advanced(const PortStates& ports, std::size_t i) const { return process.advances(i) && !ports[i].is_open(); }
  static int offset(const PortStates& ports, std::size_t port) {
    int sum = 0;
    for (std::size_t i = 0; i < port; ++i) sum += ports[i].dof();
    return sum;
  }
  /// Φ over all ports (identity where nothing is declared), Q alike.
  Eigen::MatrixXd whole(const PortStates& ports, const std::vector<Coupling>& couplings,
                        const std::vector<Eigen::MatrixXd>& blocks, bool is_transition) const {
    const int n = offset(ports, ports.size());
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n, n);
    if (is_transition) all.setIdentity();
    for (std::size_t i = 0; i < couplings.size(); ++i) {
      const auto to = static_cast<std::size_t>(couplings[i].to), from = static_cast<std::size_t>(couplings[i].from);
      all.block(offset(ports, to), offset(ports, from), ports[to].dof(), ports[from].dof()) = blocks[i];
      if (!is_transition && to != from)
        all.block(offset(ports, from), offset(ports, to), ports[from].dof(), ports[to].dof()) = blocks[i].transpose();
    }
    return all;
  }
  Eigen::MatrixXd Phi(const PortStates& ports, const Propagated& p) const {
    return whole(ports, declared().transition, p.transition, true);
  }
  Eigen::MatrixXd Q(const PortStates& ports, const Propagated& p) const {
    return whole(ports, declared().noise, p.noise, false);
  }
  PortStates after(PortStates ports, const Propagated& p) const {
    for (std::size_t i = 0; i < ports.size(); ++i)
      if (is_advanced(ports, i)) ports[i].x = p.x_plus[i];
    return ports;
  }
  std::string name(std::size_t port) const { return process.part.type->spec.ports[port].name; }

  std::shared_ptr<const Composition> composition;
  ProcessFixture process;
  std::vector<std::byte> memory;
};

Eigen::VectorXd scales(const PortStates& ports) {
  Eigen::VectorXd all(Subject::offset(ports, ports.size()));
  for (std::size_t i = 0; i < ports.size(); ++i)
    if (!ports[i].is_open()) all.segment(Subject::offset(ports, i), ports[i].dof()) = ports[i].scale;
  return all;
}

void jacobian(Trial& trial) {
  const Subject subject(trial);
  if (!subject.is_closed()) Trial::skip("it has a continuous form only; the kernel makes x+ = Phi x of it");
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(600 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.process.ports(random, 0.3);
    const ProcessInput input = subject.process.input(random, ordinary_dt);
    const Propagated nominal = subject.call(ports, input);
    if (!nominal.answer.result) Trial::skip(std::string("it refuses ordinary input: ") + nominal.answer.result.reason);
    const Eigen::MatrixXd Phi = subject.Phi(ports, nominal);
    for (std::size_t to = 0; to < ports.size(); ++to) {
      if (!subject.is_advanced(ports, to)) continue;
      const auto change = [&](const PortStates& at) -> Eigen::VectorXd {
        const Propagated p = subject.call(at, input);
        Eigen::VectorXd delta(ports[to].dof());
        ports[to].block->minus(p.x_plus[to].data(), nominal.x_plus[to].data(), delta.data());
        return delta;
      };
      for (std::size_t from = 0; from < ports.size(); ++from) {
        if (ports[from].is_open()) continue;
        const Eigen::MatrixXd block =
            Phi.block(Subject::offset(ports, to), Subject::offset(ports, from), ports[to].dof(), ports[from].dof());
        Eigen::MatrixXd D = block;
        if (to == from) D -= Eigen::MatrixXd::Identity(D.rows(), D.cols());
        const double largest = D.cwiseAbs().maxCoeff();
        const Mismatch m = compare_over_steps(ports, from, block, change, [&](Eigen::Index i, Eigen::Index j) {
          return truncation * largest + negligible * ports[to].scale[i] / ports[from].scale[j];
        });
        if (!trial.expect(!m.is_there, "Phi of '", subject.name(to), "' by '", subject.name(from), "' (", m.row, ",",
                          m.column, "): ", largest == 0 ? "nothing is declared" : "declared ",
                          largest == 0 ? "" : std::to_string(m.declared), ", differences of x+ give ", m.numeric))
          return;
      }
    }
  }
}

void noise(Trial& trial) {
  const Subject subject(trial);
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(700 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.process.ports(random, 0.3);
    for (const double dt : {1e-4, ordinary_dt, 0.3}) {
      const Propagated p = subject.call(ports, subject.process.input(random, dt));
      if (!p.answer.result) continue;
      const Eigen::MatrixXd Q = subject.Q(ports, p);
      const double largest = Q.cwiseAbs().maxCoeff();
      if (!trial.expect((Q - Q.transpose()).cwiseAbs().maxCoeff() <= 1e-12 * largest, "Qd over ", dt,
                        " s is not symmetric"))
        return;
      const Eigen::VectorXd root = Q.diagonal().cwiseMax(0).cwiseSqrt();
      if (!trial.expect((Q.diagonal().array() >= 0).all(), "Qd over ", dt, " s has a negative variance")) return;
      const Eigen::VectorXd inverse = root.unaryExpr([](double v) { return v > 0 ? 1 / v : 0; });
      const Eigen::MatrixXd correlation = inverse.asDiagonal() * Q * inverse.asDiagonal();
      const double least =
          correlation.size() ? Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff() : 0;
      if (!trial.expect(least >= -1e-9, "Qd over ", dt,
                        " s is not positive semidefinite: scaled to ones on its diagonal it has the eigenvalue ",
                        least))
        return;
    }
  }
}

void rest(Trial& trial) {
  const Subject subject(trial);
  if (!subject.is_closed()) Trial::skip("it has a continuous form only");
  auto random = trial.random(800);
  const PortStates ports = subject.process.ports(random, 0.3);
  ProcessInput input = subject.process.input(random, 0.0);
  const Propagated p = subject.call(ports, input);
  if (!p.answer.result) Trial::skip(std::string("it refuses dt = 0: ") + p.answer.result.reason);
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (!subject.is_advanced(ports, i)) continue;
    Eigen::VectorXd delta(ports[i].dof());
    ports[i].block->minus(p.x_plus[i].data(), ports[i].x.data(), delta.data());
    trial.expect((delta.cwiseAbs().array() <= 1e-12 * ports[i].scale.array()).all(), "dt = 0 moves '", subject.name(i),
                 "' by [", delta.transpose(), "]");
  }
  const Eigen::MatrixXd Phi = subject.Phi(ports, p);
  trial.expect((Phi - Eigen::MatrixXd::Identity(Phi.rows(), Phi.cols())).cwiseAbs().maxCoeff() == 0,
               "over dt = 0 Phi is not the identity");
  trial.expect(subject.Q(ports, p).cwiseAbs().maxCoeff() == 0, "over dt = 0 Qd is not zero");
}

void composition(Trial& trial) {
  const Subject subject(trial);
  if (!subject.is_closed()) Trial::skip("it has a continuous form only");
  for (int repeat = 0; repeat < trial.repeats(3); ++repeat) {
    auto random = trial.random(900 + static_cast<std::uint64_t>(repeat));
    const PortStates ports = subject.process.ports(random, 0.3);
    const ProcessInput whole = subject.process.input(random, ordinary_dt);
    ProcessInput half = whole;
    half.dt /= 2;
    const auto& fields = subject.process.part.type->spec.fields;
    for (std::size_t i = 0; i < fields.size(); ++i)
      if (fields[i].kind == FieldKind::increment) half.fields[i] /= 2;

    const Propagated once = subject.call(ports, whole);
    auto memory = subject.memory;
    const Propagated first = subject.process.call(ports, half, memory.data(), unwritten());
    const PortStates middle = subject.after(ports, first);
    const Propagated second = subject.process.call(middle, half, memory.data(), unwritten());
    if (!once.answer.result || !first.answer.result || !second.answer.result) Trial::skip("it refuses ordinary input");

    for (std::size_t i = 0; i < ports.size(); ++i) {
      if (!subject.is_advanced(ports, i)) continue;
      Eigen::VectorXd change(ports[i].dof()), gap(ports[i].dof());
      ports[i].block->minus(once.x_plus[i].data(), ports[i].x.data(), change.data());
      ports[i].block->minus(second.x_plus[i].data(), once.x_plus[i].data(), gap.data());
      if (!trial.expect(gap.norm() <= truncation * change.norm() + (negligible * ports[i].scale).norm(),
                        "one step and two halves move '", subject.name(i), "' differently: by [", change.transpose(),
                        "] and [", (change + gap).transpose(), "]"))
        return;
    }
    const Eigen::VectorXd scale = scales(ports);
    const Eigen::MatrixXd Phi = subject.Phi(ports, once);
    const Eigen::MatrixXd Phi_2 = subject.Phi(middle, second);
    const Eigen::MatrixXd split = Phi_2 * subject.Phi(ports, first);
    const Eigen::MatrixXd D = Phi - Eigen::MatrixXd::Identity(Phi.rows(), Phi.cols());
    for (std::size_t to = 0; to < ports.size(); ++to)
      for (std::size_t from = 0; from < ports.size(); ++from) {
        const int row = Subject::offset(ports, to), column = Subject::offset(ports, from);
        if (!ports[to].dof() || !ports[from].dof()) continue;
        const auto d = D.block(row, column, ports[to].dof(), ports[from].dof());
        for (Eigen::Index i = row; i < row + ports[to].dof(); ++i)
          for (Eigen::Index j = column; j < column + ports[from].dof(); ++j)
            if (!trial.expect(std::abs(split(i, j) - Phi(i, j)) <=
                                  2 * truncation * d.cwiseAbs().maxCoeff() + negligible * scale[i] / scale[j],
                              "Phi of '", subject.name(to), "' by '", subject.name(from), "' over a step is ",
                              Phi(i, j), ", over its halves ", split(i, j)))
              return;
      }
    const Eigen::MatrixXd Q = subject.Q(ports, once);
    const Eigen::MatrixXd Q_split = Phi_2 * subject.Q(ports, first) * Phi_2.transpose() + subject.Q(middle, second);
    for (Eigen::Index i = 0; i < Q.rows(); ++i)
      for (Eigen::Index j = 0; j < Q.cols(); ++j) {
        const double size = std::sqrt(Q(i, i) * Q(j, j));
        if (size == 0) continue;  // a model may leave out what enters by integration only
        if (!trial.expect(std::abs(Q(i, j) - Q_split(i, j)) <= 0.05 * size, "Qd(", i, ",", j, ") over a step is ",
                          Q(i, j), ", over its halves ", Q_split(i, j)))
          return;
      }
  }
}

void discretization(Trial& trial) {
  const Subject subject(trial);
  if (!subject.is_closed() || !subject.declared().has_continuous_form) Trial::skip("it has one form only");
  auto random = trial.random(950);
  const PortStates ports = subject.process.ports(random, 0.3);
  const Propagated closed = subject.call(ports, subject.process.input(random, ordinary_dt));
  std::vector<std::vector<double>> F_blocks, Q_blocks;
  std::vector<double*> F_at, Q_at;
  const auto make = [&](const std::vector<Coupling>& couplings, auto& blocks, auto& at) {
    for (const auto& c : couplings) {
      const auto rows = static_cast<std::size_t>(ports[static_cast<std::size_t>(c.to)].dof());
      blocks.emplace_back(c.structure == Structure::diagonal
                              ? rows
                              : rows * static_cast<std::size_t>(ports[static_cast<std::size_t>(c.from)].dof()));
    }
    for (auto& block : blocks) at.push_back(block.data());
  };
  make(subject.declared().transition, F_blocks, F_at);
  make(subject.declared().noise, Q_blocks, Q_at);
  legacy::linearized(*subject.process.part.model, pointers(ports).data(), {F_at.data(), Q_at.data()});
  const auto dense = [&](const std::vector<Coupling>& couplings, const auto& blocks) {
    std::vector<Eigen::MatrixXd> all;
    for (std::size_t i = 0; i < couplings.size(); ++i) {
      const int rows = ports[static_cast<std::size_t>(couplings[i].to)].dof(),
                columns = ports[static_cast<std::size_t>(couplings[i].from)].dof();
      if (couplings[i].structure == Structure::diagonal)
        all.push_back(vector_at(blocks[i].data(), rows).asDiagonal());
      else
        all.push_back(matrix_at(blocks[i].data(), rows, columns));
    }
    return all;
  };
  const int n = Subject::offset(ports, ports.size());
  Eigen::MatrixXd F =
      subject.whole(ports, subject.declared().transition, dense(subject.declared().transition, F_blocks), false);
  // whole(…, false) mirrors, which F is not: only its declared blocks count.
  F.setZero();
  const auto parts = dense(subject.declared().transition, F_blocks);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& c = subject.declared().transition[i];
    F.block(Subject::offset(ports, static_cast<std::size_t>(c.to)),
            Subject::offset(ports, static_cast<std::size_t>(c.from)), parts[i].rows(), parts[i].cols()) = parts[i];
  }
  const Eigen::MatrixXd G =
      subject.whole(ports, subject.declared().noise, dense(subject.declared().noise, Q_blocks), false);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  A.topLeftCorner(n, n) = -F * ordinary_dt;
  A.topRightCorner(n, n) = G * ordinary_dt;
  A.bottomRightCorner(n, n) = F.transpose() * ordinary_dt;
  const Eigen::MatrixXd E = A.exp();
  const Eigen::MatrixXd Phi = E.bottomRightCorner(n, n).transpose();
  const Eigen::MatrixXd Q = Phi * E.topRightCorner(n, n);
  const Eigen::MatrixXd Phi_closed = subject.Phi(ports, closed), Q_closed = subject.Q(ports, closed);
  trial.expect((Phi - Phi_closed).cwiseAbs().maxCoeff() <= 1e-9 * Phi.cwiseAbs().maxCoeff(),
               "closed and continuous form give another Phi:\n", Phi_closed, "\nand\n", Phi);
  trial.expect((Q - Q_closed).cwiseAbs().maxCoeff() <= 1e-6 * Q.cwiseAbs().maxCoeff(),
               "closed and continuous form give another Qd:\n", Q_closed, "\nand\n", Q);
}

// ---- a filter that believes the model, on a world that is the model

double quantile(double dof, double p) { return boost::math::quantile(boost::math::chi_squared(dof), p); }

Eigen::VectorXd draw(const Eigen::MatrixXd& covariance, std::mt19937_64& random) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(covariance);
  return solver.eigenvectors() *
         solver.eigenvalues().cwiseMax(0).cwiseSqrt().cwiseProduct(normals(random, covariance.rows()));
}

void consistency(Trial& trial) {
  // The miniature, and where nothing drives it a direct measurement of the vectors it advances.
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  Json config = miniature(trial, type, catalog, example_of(type.spec));
  const bool is_driven = !type.spec.fields.empty();
  constexpr double seen_sigma = 0.7;
  if (!is_driven) {
    const auto plain = compose(trial, config);
    const auto part = parts::process(*plain, filter_name, component_name);
    const auto& value = part.ports.front();
    const auto& declared = value.block->declaration();
    if (declared.kind.rfind("vector:", 0) != 0)
      Trial::skip("nothing is known that measures a block of the kind '" + declared.kind + "'");
    Json fields = Json::object(), H = Json::array(), sigma = Json::array();
    for (int i = 0; i < declared.dof(); ++i) {
      fields["z" + std::to_string(i)] = {{"unit", declared.error[static_cast<std::size_t>(i)].unit}};
      Json row = Json::array();
      for (int j = 0; j < declared.dof(); ++j) row.push_back(i == j ? 1 : 0);
      H.push_back(row);
      sigma.push_back(seen_sigma);
    }
    config["sources"]["seen"] = {{"type", "core/pushed"}, {"fields", fields}};
    config["filters"][filter_name]["measurements"]["seen"] = {{"type", "core/linear_measurement"},
                                                              {"channel", "seen"},
                                                              {"blocks", {{"x", value.name}}},
                                                              {"H", H},
                                                              {"sigma", sigma}};
  }
  const auto composition = compose(trial, config);
  const FilterInfo& info = composition->filters().front();
  const ProcessFixture process(trial, *composition);
  if (!process.part.model->declaration().has_closed_form)
    Trial::skip("it has a continuous form only: there is nothing to simulate with");

  const int runs = trial.repeats(30), steps = 30;
  double sum = 0, dof_sum = 0;
  for (int run = 0; run < runs; ++run) {
    auto random = trial.random(10'000 + static_cast<std::uint64_t>(run));
    Session filter(composition);
    const double dt = is_driven ? ordinary_dt : 0.2;
    Time t = 0;
    const ChannelId channel = is_driven ? ChannelId{info.input_channel} : filter.channel("seen");
    const auto push = [&](const std::vector<double>& numbers) {
      const Time next = t + static_cast<Time>(std::llround(dt * 1e9));
      filter.push(channel, is_driven ? t : no_time, next, numbers);
      t = next;
    };
    const auto values_of = [&](std::span<const double> state, const BlockInfo& block) {
      return std::vector<double>(state.begin() + block.stored_offset,
                                 state.begin() + block.stored_offset + block.declaration->stored_size);
    };
    // The first sample starts the filter; the truth is drawn around what it then believes.
    std::vector<double> first(
        is_driven
            ? type.spec.fields.size()
            : static_cast<std::size_t>(
                  parts::process(*composition, filter_name, component_name).ports.front().block->declaration().dof()),
        0.0);
    if (is_driven)
      filter.push(channel, no_time, t, process.input(random, dt).fields);
    else
      filter.push(channel, no_time, t, first);
    if (!filter.started(FilterId{0})) Trial::skip("the miniature filter does not start");
    const MatrixView P = filter.covariance(FilterId{0});
    const Eigen::VectorXd error = draw(P.as(), random);
    PortStates truth = process.ports(random, 0.0);
    for (auto& port : truth) {
      if (port.is_open()) continue;
      for (const auto& block : info.blocks)
        if (block.name == port.name) {
          port.x = values_of(filter.state(FilterId{0}), block);
          const Eigen::VectorXd delta = error.segment(block.first_row, port.dof());
          port.block->plus(port.x.data(), delta.data(), port.x.data());
        }
    }
    std::vector<std::byte> memory(process.part.model->declaration().memory_bytes);
    process.part.model->start(memory.data());
    for (int step = 0; step < steps; ++step) {
      const ProcessInput input = process.input(random, dt);
      const Propagated p = process.call(truth, input, memory.data(), unwritten());
      if (!p.answer.result) Trial::skip("it refuses ordinary input");
      std::vector<Eigen::VectorXd> shocks(truth.size());
      int n = 0;
      for (const auto& port : truth) n += port.dof();
      Eigen::MatrixXd Q = Eigen::MatrixXd::Zero(n, n);
      for (std::size_t i = 0; i < p.noise.size(); ++i) {
        const auto& c = process.part.model->declaration().noise[i];
        const auto to = static_cast<std::size_t>(c.to), from = static_cast<std::size_t>(c.from);
        Q.block(Subject::offset(truth, to), Subject::offset(truth, from), truth[to].dof(), truth[from].dof()) =
            p.noise[i];
        Q.block(Subject::offset(truth, from), Subject::offset(truth, to), truth[from].dof(), truth[to].dof()) =
            p.noise[i].transpose();
      }
      const Eigen::VectorXd shock = draw(Q, random);
      for (std::size_t i = 0; i < truth.size(); ++i) {
        if (!process.advances(i) || truth[i].is_open()) continue;
        truth[i].x = p.x_plus[i];
        const Eigen::VectorXd delta = shock.segment(Subject::offset(truth, i), truth[i].dof());
        truth[i].block->plus(truth[i].x.data(), delta.data(), truth[i].x.data());
      }
      if (is_driven) {
        push(input.fields);
      } else {
        std::vector<double> z = truth.front().x;
        for (auto& number : z) number += seen_sigma * normal(random);
        push(z);
      }
    }
    if (!trial.expect(filter.healthy(FilterId{0}), "the miniature filter breaks: ", filter.diagnosis(FilterId{0})))
      return;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      if (!process.advances(i) || truth[i].is_open()) continue;
      for (const auto& block : info.blocks) {
        if (block.name != truth[i].name) continue;
        Eigen::VectorXd e(truth[i].dof());
        const auto estimate = values_of(filter.state(FilterId{0}), block);
        truth[i].block->minus(truth[i].x.data(), estimate.data(), e.data());
        const Eigen::MatrixXd own =
            filter.covariance(FilterId{0}).as().block(block.first_row, block.first_row, truth[i].dof(), truth[i].dof());
        sum += e.dot(own.ldlt().solve(e));
        dof_sum += truth[i].dof();
      }
    }
  }
  // Blocks of one filter are correlated, so their sum is wider than its χ²: the band is that of one block of three a run.
  const double mean = sum / dof_sum, wide = std::min<double>(dof_sum, 3.0 * runs);
  const double low = quantile(wide, 0.0001) / wide, high = quantile(wide, 0.9999) / wide;
  trial.expect(mean > low && mean < high, "NEES of what it advances is ", mean, " a degree of freedom over ", runs,
               " runs of a world that is the model itself; 99.98 % band ", low, " to ", high);
}

}  // namespace

std::vector<Check> process_checks() {
  const std::vector<Role> roles = {Role::process_model};
  return {
      {"numbers.process.rest", 2, roles, {"life.repeatable"}, "dt = 0 gives x+ = x, Phi = I, Qd = 0", rest},
      {"numbers.process.jacobian",
       2,
       roles,
       {"life.repeatable"},
       "Phi is the derivative of x+ on the manifold, and what is not declared is zero",
       jacobian},
      {"numbers.process.noise", 2, roles, {"life.repeatable"}, "Qd is symmetric and positive semidefinite", noise},
      {"numbers.process.composition",
       3,
       roles,
       {"numbers.process.jacobian", "numbers.process.noise", "numbers.process.rest"},
       "a step equals its two halves: x+, Phi, Qd",
       composition},
      {"numbers.process.discretization",
       3,
       roles,
       {"numbers.process.composition"},
       "closed and continuous form agree",
       discretization},
      {"numbers.process.consistency",
       5,
       roles,
       {"numbers.process.composition", "numbers.process.discretization"},
       "NEES of a filter on a world that is the model stays in its band",
       consistency},
  };
}

}  // namespace binnacle::conform
