// SPDX-License-Identifier: Apache-2.0
#include "follower.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algebra/decompositions.hpp"
#include "wording/block_call.hpp"

namespace binnacle::covariance {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const BlockInfo* block_named(const FilterInfo& info, const std::string& name) {
  const auto found =
      std::find_if(info.blocks.begin(), info.blocks.end(), [&](const auto& b) { return b.name == name; });
  return found == info.blocks.end() ? nullptr : &*found;
}

MatrixXd columns_of(const MatrixXd& H, const BlockInfo* block) {
  return H.middleCols(block->first_row, static_cast<Index>(block->active.size()));
}

/// A row over the block's error components as one over all rows of P.
VectorXd spread(const VectorXd& row, const BlockInfo* block, int dof) {
  VectorXd all = VectorXd::Zero(dof);
  for (std::size_t a = 0; block && a < block->active.size(); ++a)
    all[block->first_row + static_cast<Index>(a)] = row[block->active[a]];
  return all;
}

/// P of the start with what the errors of some blocks have from others.
MatrixXd tied(const MatrixXd& P, const std::vector<InitialTie>& ties, const FilterInfo& info) {
  MatrixXd T = MatrixXd::Identity(P.rows(), P.rows());
  for (const auto& tie : ties) {
    const BlockInfo &to = *block_named(info, tie.block), &from = *block_named(info, tie.of);
    for (std::size_t i = 0; i < to.active.size(); ++i)
      for (std::size_t j = 0; j < from.active.size(); ++j)
        T(to.first_row + static_cast<Index>(i), from.first_row + static_cast<Index>(j)) +=
            tie.by(to.active[i], from.active[j]);
  }
  return T * P * T.transpose();
}

/// The filter's: what is considered has none.
MatrixXd gain(const Event& update, const MatrixXd& P, const FilterInfo& info) {
  MatrixXd K = algebra::Cholesky(update.S).solve(update.H * P).transpose();
  for (const auto& block : info.blocks)
    for (std::size_t a = 0; a < block.active.size(); ++a)
      if (block.use[static_cast<std::size_t>(block.active[a])] == "considered")
        K.row(block.first_row + static_cast<Index>(a)).setZero();
  return K;
}

}  // namespace

Follower::Follower(const Plan& plan, const std::vector<std::string>& names, std::vector<Time> times)
    : plan_(plan),
      info_(plan.composition->filters()[static_cast<std::size_t>(plan.filter)]),
      true_info_(plan.composition->filters()[static_cast<std::size_t>(plan.truth)]),
      is_own_truth_(plan.filter == plan.truth),
      joint_(true_info_, info_),
      model_log_(info_,
                 [this](Event event) {
                   if (is_own_truth_) true_events_.push_back(event);
                   take(events_, std::move(event));
                 }),
      true_log_(true_info_, [this](Event event) { take(true_events_, std::move(event)); }),
      times_(std::move(times)) {
  std::sort(times_.begin(), times_.end());
  for (const auto& name : names) add_subject(name);
}

void Follower::add_subject(const std::string& name) {
  const SubjectName named = subject_named(name, plan_.implied_states);
  Subject subject;
  subject.name = name;
  if (named.implied_state) subject.measurement = named.implied_state->measurement;
  subject.block = block_named(info_, named.block);
  subject.true_block = block_named(true_info_, named.block);
  const Component component = *component_named(*subject.block->declaration, named.component);
  subject.components = component.errors;
  subject.output = component.output;
  const auto& active = subject.block->active;
  for (const int c : subject.components)
    if (std::find(active.begin(), active.end(), c) == active.end())
      throw Broken("'" + name + "' is neither estimated nor considered: it has no variance");
  subjects_.push_back(std::move(subject));
}

void Follower::take(std::deque<Event>& events, Event event) {
  if (is_over()) return;
  if (plan_.duration > 0 && event.t > plan_.duration) {
    is_over_ = true;
    return;
  }
  events.push_back(std::move(event));
  try {
    follow();
  } catch (const Broken& broken) {
    why_ = broken.what();
  }
}

/// As far as the truth has come.
void Follower::follow() {
  while (!events_.empty()) {
    const Event& event = events_.front();
    switch (event.kind) {
      case Event::started:
        if (true_events_.empty()) return;
        start();
        break;
      case Event::stepped:
        if (!times_.empty() && times_.front() < event.t) {
          follow_truth_to(t_);
          note_blocks();
          std::erase_if(times_, [&](Time t) { return t < event.t; });
        }
        joint_.step_model(event.Phi);
        P_ = event.P1;
        break;
      case Event::offered:
        if (!follow_truth_to(event)) return;
        measure(event, true_events_.front());
        true_events_.pop_front();
    }
    t_ = event.t;
    x_ = event.x;
    if (event.kind == Event::offered) note_blocks();
    events_.pop_front();
  }
}

void Follower::start() {
  if (true_events_.front().kind != Event::started || true_events_.front().t != events_.front().t)
    throw Broken("the truth does not start with the filter");
  P_ = events_.front().P1;
  joint_.start(tied(true_events_.front().P1, plan_.initial, true_info_));
  true_events_.pop_front();
}

/// To the counterpart of the filter's measurement, which is then the next. False: it has not come yet.
bool Follower::follow_truth_to(const Event& update) {
  for (; !true_events_.empty(); true_events_.pop_front()) {
    const Event& truth = true_events_.front();
    if (truth.t > update.t) break;
    if (truth.kind == Event::stepped)
      joint_.step_truth(truth.Phi, truth.Qd);
    else if (truth.t == update.t && truth.measurement == update.measurement)
      return true;
  }
  if (true_events_.empty()) return false;
  throw Broken("the truth has no measurement '" + update.measurement + "' where the filter has one");
}

void Follower::follow_truth_to(Time t) {
  for (; !true_events_.empty() && true_events_.front().t <= t; true_events_.pop_front())
    if (true_events_.front().kind == Event::stepped)
      joint_.step_truth(true_events_.front().Phi, true_events_.front().Qd);
}

void Follower::finish() {
  if (!why_.empty()) throw Broken(why_);
  if (!events_.empty())
    throw Broken("the truth has no measurement '" + events_.front().measurement + "' where the filter has one");
  if (t_ == no_time)
    throw Broken("filter '" + info_.name + "' never started; what a program pushes is fed by 'channels'");
  follow_truth_to(t_);
  note_blocks();
}

void Follower::measure(const Event& event, const Event& truth) {
  const std::string& name = event.measurement;
  const bool is_seen = event.outcome == Outcome::accepted || event.outcome == Outcome::withheld;
  if (!is_seen) throw Broken("measurement '" + name + "' was not accepted: " + event.reason);
  if (truth.H.rows() != event.H.rows()) throw Broken("measurement '" + name + "' has other rows in the truth");
  note_implied_states(event, truth);
  if (event.outcome == Outcome::withheld) return;
  const MatrixXd K = gain(event, P_, info_);
  const MatrixXd A = MatrixXd::Identity(info_.dof, info_.dof) - K * event.H;
  P_ = (A * P_ * A.transpose() + K * event.R * K.transpose()).eval();
  joint_.update(name, truth.H, truth.R, event.H, K);
}

void Follower::note(Subject& subject, Time t, const VectorXd& parts, double own_variance) {
  subject.parts = parts;
  subject.names = joint_.sources();
  const Point point{seconds(t), parts.sum(), own_variance};
  if (!subject.points.empty() && subject.points.back().t == point.t)
    subject.points.back() = point;
  else
    subject.points.push_back(point);
}

VectorXd Follower::joined(const VectorXd& of_truth, const VectorXd& of_model) const {
  VectorXd c(joint_.true_size() + joint_.model_size());
  c << of_truth, -of_model;
  return c;
}

/// ∂output/∂δ at the estimate by central differences on the block's manifold.
VectorXd Follower::output_row(const Subject& subject) const {
  constexpr double step = 1e-4;
  const auto& declaration = *subject.block->declaration;
  const auto& output = declaration.outputs[static_cast<std::size_t>(subject.output)];
  const ConstVectorView x(x_.data() + subject.block->stored_offset, declaration.stored_size);
  std::vector<double> moved(static_cast<std::size_t>(declaration.stored_size)), above(declaration.outputs.size()),
      below = above;
  VectorXd delta = VectorXd::Zero(declaration.dof()), row = delta;
  for (Index i = 0; i < delta.size(); ++i) {
    const auto read_at = [&](double by, std::vector<double>& outputs) {
      delta[i] = by;
      wording::call_block(*subject.block, "plus and read", no_time, [&] {
        subject.block->block->plus(x, delta, moved);
        subject.block->block->read(moved, outputs);
      });
    };
    read_at(step, above);
    read_at(-step, below);
    delta[i] = 0;
    const double difference =
        above[static_cast<std::size_t>(subject.output)] - below[static_cast<std::size_t>(subject.output)];
    row[i] = (output.is_angle ? std::remainder(difference, 2 * std::numbers::pi) : difference) / (2 * step);
  }
  return row;
}

void Follower::note_blocks() {
  for (auto& subject : subjects_) {
    if (!subject.measurement.empty()) continue;
    std::vector<VectorXd> rows;
    if (subject.output >= 0) rows.push_back(output_row(subject));
    for (const int c : subject.components) rows.push_back(VectorXd::Unit(subject.block->declaration->dof(), c));
    VectorXd parts = VectorXd::Zero(static_cast<Index>(joint_.sources().size()));
    double own = 0;
    for (const auto& row : rows) {
      const VectorXd of_model = spread(row, subject.block, info_.dof);
      parts += joint_.variance(joined(spread(row, subject.true_block, true_info_.dof), of_model));
      own += of_model.dot(P_ * of_model);
    }
    note(subject, t_, parts, own);
  }
}

/// x̂_b ⊞ B r with B H_b = I (sdk/docs/covariance.md). Before the update: the estimate does not know v yet. Its error is
/// S_b x − B (H x + v) of what is true, less S_b x̂ − B H x̂ of what the filter holds.
void Follower::note_implied_states(const Event& event, const Event& truth) {
  for (auto& subject : subjects_) {
    if (subject.measurement != event.measurement) continue;
    const MatrixXd B = algebra::left_inverse(columns_of(event.H, subject.block), event.R);
    if (B.size() == 0)
      throw Broken("measurement '" + event.measurement + "' does not determine block '" + subject.block->name + "'");
    const auto& active = subject.block->active;
    const int source = joint_.source("noise of " + event.measurement);
    VectorXd parts = VectorXd::Zero(static_cast<Index>(joint_.sources().size()));
    double own = 0;
    for (const int c : subject.components) {
      const VectorXd unit = VectorXd::Unit(subject.block->declaration->dof(), c);
      const VectorXd b = B.row(std::find(active.begin(), active.end(), c) - active.begin()).transpose();
      const VectorXd of_truth = spread(unit, subject.true_block, true_info_.dof) - truth.H.transpose() * b;
      const VectorXd of_model = spread(unit, subject.block, info_.dof) - event.H.transpose() * b;
      parts += joint_.variance(joined(of_truth, of_model));
      parts[source] += b.dot(truth.R * b);
      own += of_model.dot(P_ * of_model) + b.dot(event.R * b);
    }
    note(subject, event.t, parts, own);
  }
}

}  // namespace binnacle::covariance
