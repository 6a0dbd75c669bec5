// SPDX-License-Identifier: Apache-2.0
#include "process_consistency.hpp"

#include <algorithm>
#include <cmath>

#include "algebra/decompositions.hpp"
#include "binnacle/session.hpp"
#include "chi_squared/chi_squared.hpp"

namespace binnacle::conform {

namespace {

constexpr double seen_sigma = 0.7;
constexpr int steps = 30;

/// The miniature, and where nothing drives it a direct measurement of the first vector that it advances.
std::shared_ptr<const Composition> world_of(Trial& trial, bool is_driven) {
  const Catalog catalog = load_catalog(trial);
  const ComponentType& type = component(trial, catalog);
  Json config = miniature(trial, type, catalog, example_of(type.spec));
  if (is_driven) return compose(trial, config);
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
  return compose(trial, config);
}

/// One filter and its truth.
class ProcessRun {
 public:
  ProcessRun(const std::shared_ptr<const Composition>& composition, const ProcessFixture& process, bool is_driven,
             std::mt19937_64 random)
      : composition_(composition),
        process_(process),
        is_driven_(is_driven),
        random_(random),
        filter_(composition),
        channel_(is_driven ? ChannelId{info().input_channel} : filter_.channel("seen")),
        memory_(process.caller.fresh_memory()) {
    // The first sample starts the filter; the truth is drawn around what it then believes.
    truth_ = process_.ports(random_, 0.0);
    filter_.push(channel_, no_time, time_,
                 is_driven ? process_.step(random_, dt()).fields()
                           : std::vector<double>(static_cast<std::size_t>(truth_.front().dof()), 0.0));
    if (!filter_.started(FilterId{0})) Trial::skip("the miniature filter does not start");
    const Eigen::VectorXd error = draw(filter_.covariance(FilterId{0}).as(), random_);
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      if (truth_[i].is_open()) continue;
      const BlockInfo& block = block_of(i);
      const Eigen::VectorXd delta = error.segment(block.first_row, truth_[i].dof());
      const std::vector<double> from = estimate(block);
      truth_[i].block->plus(from, delta, truth_[i].x);
    }
  }

  void step() {
    const DrivenStep step = process_.step(random_, dt());
    const auto p = process_.call(truth_, step, memory_);
    if (!p.result) Trial::skip(std::string("it refuses ordinary input: ") + p.result.reason);
    memory_ = p.memory;
    const Eigen::VectorXd shock = draw(process_.caller.Q(truth_, p), random_);
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      if (!process_.caller.moves(truth_, i)) continue;
      const Eigen::VectorXd delta = shock.segment(testing::offset(truth_, i), truth_[i].dof());
      truth_[i].block->plus(p.x_plus[i], delta, truth_[i].x);
    }
    std::vector<double> numbers = is_driven_ ? step.fields() : truth_.front().x;
    if (!is_driven_)
      for (auto& number : numbers) number += seen_sigma * normal(random_);
    const Time next = time_ + static_cast<Time>(std::llround(dt() * 1e9));
    filter_.push(channel_, is_driven_ ? time_ : no_time, next, numbers);
    time_ = next;
  }

  /// Adds the squared errors of what the model advances, in units of the filter's own covariance.
  void add_to(double& sum, double& dof) {
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      if (!process_.caller.moves(truth_, i)) continue;
      const BlockInfo& block = block_of(i);
      Eigen::VectorXd e(truth_[i].dof());
      const std::vector<double> estimated = estimate(block);
      truth_[i].block->minus(truth_[i].x, estimated, e);
      const Eigen::MatrixXd own = filter_.covariance(FilterId{0})
                                      .as()
                                      .block(block.first_row, block.first_row, truth_[i].dof(), truth_[i].dof());
      sum += e.dot(algebra::PivotedCholesky(own).solve_vector(e));
      dof += truth_[i].dof();
    }
  }
  const Session& filter() const { return filter_; }

 private:
  double dt() const { return is_driven_ ? 0.01 : 0.2; }
  const FilterInfo& info() const { return composition_->filters().front(); }
  const BlockInfo& block_of(std::size_t port) const {
    const auto& blocks = info().blocks;
    const auto found = std::find_if(blocks.begin(), blocks.end(),
                                    [&](const auto& block) { return block.name == process_.part.ports[port].name; });
    if (found == blocks.end()) Trial::skip("the filter has no block '" + process_.part.ports[port].name + "'");
    return *found;
  }
  std::vector<double> estimate(const BlockInfo& block) const {
    const auto state = filter_.state(FilterId{0});
    return {state.begin() + block.stored_offset, state.begin() + block.stored_offset + block.declaration->stored_size};
  }

  const std::shared_ptr<const Composition>& composition_;
  const ProcessFixture& process_;
  bool is_driven_;
  std::mt19937_64 random_;
  Session filter_;
  ChannelId channel_;
  std::vector<std::byte> memory_;
  PortStates truth_;
  Time time_ = 0;
};

}  // namespace

void process_consistency(Trial& trial) {
  const auto plain = compose_example(trial);
  const ProcessFixture first(trial, *plain);
  if (!first.is_closed()) Trial::not_applicable("it has a continuous form only: there is nothing to simulate with");
  const bool is_driven = !first.part.type->spec.fields.empty();
  const auto composition = world_of(trial, is_driven);
  const ProcessFixture process(trial, *composition);
  const int runs = trial.repeats(30);
  double sum = 0, dof = 0;
  for (int number = 0; number < runs; ++number) {
    ProcessRun run(composition, process, is_driven, trial.random(10'000 + static_cast<std::uint64_t>(number)));
    for (int step = 0; step < steps; ++step) run.step();
    if (!trial.expect(run.filter().healthy(FilterId{0}),
                      "the miniature filter breaks: ", run.filter().diagnosis(FilterId{0})))
      return;
    run.add_to(sum, dof);
  }
  // Blocks of one filter are correlated, so their sum is wider than its χ²: the band is that of one block of three a run.
  const double mean = sum / dof, wide = std::min<double>(dof, 3.0 * runs);
  const double low = chi_squared_quantile(wide, 0.0001) / wide, high = chi_squared_quantile(wide, 0.9999) / wide;
  trial.expect(mean > low && mean < high, "NEES of what it advances is ", mean, " a degree of freedom over ", runs,
               " runs of a world that is the model itself; 99.98 % band ", low, " to ", high);
}

}  // namespace binnacle::conform
