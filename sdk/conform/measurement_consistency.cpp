// SPDX-License-Identifier: Apache-2.0
#include "measurement_consistency.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "algebra/decompositions.hpp"
#include "binnacle/session.hpp"
#include "chi_squared/chi_squared.hpp"

namespace binnacle::conform {

namespace {

constexpr int updates = 5;

struct SeenSubject : MeasurementSubject {
  using MeasurementSubject::MeasurementSubject;
  testing::Measured call(const PortStates& ports, const SampleNumbers& sample) const {
    return measurement.call(ports, sample, memory);
  }
  /// What is seen of the truth, with noise of the model's own R.
  SampleNumbers seen(const PortStates& truth, std::mt19937_64& random) const {
    const auto at_truth = call(truth, measurement.sample(truth, random));
    if (!at_truth.result)
      Trial::skip(std::string("it refuses a sample that it should accept: ") + at_truth.result.reason);
    if (at_truth.residual.size() == 0) Trial::skip("it accepts no row of a sample that it should accept");
    const Eigen::VectorXd noise = draw(at_truth.R, random);
    const SampleNumbers sample = measurement.sample(truth, random, noise);
    const auto made = call(truth, sample);
    if (made.residual.size() != noise.size() || !((made.residual - noise).norm() <= 1e-3 * noise.norm()))
      Trial::skip("no sample is found that shows a wanted residual");
    return sample;
  }
};

/// Normalized innovations squared, and their degrees of freedom.
struct Sum {
  double nis = 0, dof = 0;
  int left_out = 0;  // runs with a gated sample
  double mean() const { return nis / dof; }
  double low() const { return chi_squared_quantile(dof, 0.0001) / dof; }
  double high() const { return chi_squared_quantile(dof, 0.9999) / dof; }
  bool is_inside() const { return dof > 0 && mean() > low() && mean() < high(); }
};

// ---- an extended Kalman filter of a few lines, whose prior can be shrunk

/// P over the ports that a filter of the miniature starts with; where it needs more to start than this suite can push,
/// of the size of the values that other checks try.
Eigen::MatrixXd prior_of(const SeenSubject& subject, const PortStates& ports, const Session* started) {
  const int n = testing::offset(ports, ports.size());
  Eigen::MatrixXd P = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (ports[i].is_open()) continue;
    auto own = P.block(testing::offset(ports, i), testing::offset(ports, i), ports[i].dof(), ports[i].dof());
    own = (0.01 * ports[i].scale.cwiseAbs2()).asDiagonal();
    if (!started) continue;
    for (const auto& block : subject.composition->filters().front().blocks)
      if (block.name == subject.measurement.part.ports[i].name)
        own = started->covariance(FilterId{0})
                  .as()
                  .block(block.first_row, block.first_row, ports[i].dof(), ports[i].dof());
  }
  return P;
}

Eigen::MatrixXd H_of(const SeenSubject& subject, const PortStates& ports, const testing::Measured& m) {
  const auto& reads = subject.measurement.part.model->declaration().read_ports;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(m.residual.size(), testing::offset(ports, ports.size()));
  for (std::size_t i = 0; i < reads.size(); ++i)
    H.middleCols(testing::offset(ports, static_cast<std::size_t>(reads[i])), m.H[i].cols()) = m.H[i];
  return H;
}

void inject(PortStates& ports, const Eigen::VectorXd& delta) {
  for (std::size_t i = 0; i < ports.size(); ++i) {
    if (ports[i].is_open()) continue;
    const Eigen::VectorXd own = delta.segment(testing::offset(ports, i), ports[i].dof());
    const std::vector<double> from = ports[i].x;
    ports[i].block->plus(from, own, ports[i].x);
  }
}

/// One run whose prior standard deviations, and the truth's errors with them, are `share` of those of P.
void believe(const SeenSubject& subject, const Eigen::MatrixXd& prior, double share, std::mt19937_64 random, Sum& sum) {
  PortStates estimate = subject.measurement.ports(random, 0.0), truth = estimate;
  Eigen::MatrixXd P = share * share * prior;
  inject(truth, draw(P, random));
  for (int k = 0; k < updates; ++k) {
    const auto m = subject.call(estimate, subject.seen(truth, random));
    if (!m.result || m.residual.size() == 0) Trial::skip("it refuses a sample that it should accept");
    const Eigen::MatrixXd H = H_of(subject, estimate, m);
    const Eigen::MatrixXd S = H * P * H.transpose() + m.R;
    const algebra::PivotedCholesky factored(S);
    sum.nis += m.residual.dot(factored.solve_vector(m.residual));
    sum.dof += static_cast<double>(m.residual.size());
    const Eigen::MatrixXd K = factored.solve(H * P).transpose();
    const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(P.rows(), P.cols()) - K * H;
    P = (A * P * A.transpose() + K * m.R * K.transpose()).eval();
    inject(estimate, K * m.residual);
  }
}

Sum believe_often(Trial& trial, const SeenSubject& subject, const Eigen::MatrixXd& prior, double share) {
  Sum sum;
  for (int run = 0; run < trial.repeats(40); ++run)
    believe(subject, prior, share, trial.random(20'000 + static_cast<std::uint64_t>(run)), sum);
  return sum;
}

/// A wrong model is wrong however small the errors are; what a right one leaves out is of second order in them.
void judge(Trial& trial, const SeenSubject& subject, const Eigen::MatrixXd& prior, const std::string& found) {
  std::ostringstream table;
  table.precision(4);
  Sum last;
  double first = NAN;
  for (const double share : {1.0, 0.25, 0.0625, 0.015625, 0.00390625}) {
    last = believe_often(trial, subject, prior, share);
    if (std::isnan(first)) first = last.mean();
    table << (share == 1.0 ? "" : ", ") << last.mean() << " at 1/" << 1 / share;
    if (last.is_inside() && share < 1) break;
  }
  const std::string shrunk = "; with prior sigmas (and the truth's errors) so much smaller it is " + table.str();
  if (last.is_inside() && std::abs(last.mean() - 1) < std::abs(first - 1))
    trial.warn(found, shrunk,
               ": the model is right, and the prior sigmas are so wide that its second order exceeds R. A filter that "
               "starts with them is overconfident after its first update");
  else
    trial.fail(found, shrunk, ": the excess does not go with the sigmas, so residual, H or R is wrong");
}

// ---- the real filter

/// One filter of the miniature and its truth. Its first sample, exactly as predicted, starts it.
class MeasurementRun {
 public:
  MeasurementRun(const SeenSubject& subject, std::mt19937_64 random)
      : subject_(subject), random_(random), filter_(subject.composition) {
    const Json config = Json::parse(subject.composition->config());
    channel_ = filter_.channel(
        config.at("filters").at(filter_name).at("measurements").at(component_name).at("channel").get<std::string>());
    truth_ = subject.measurement.ports(random_, 0.0);
    push(subject.measurement.sample(truth_, random_), 1'000'000'000);
    if (!filter_.started(FilterId{0})) Trial::skip("the miniature filter does not start");
    before_ = filter_.counts(MeasurementId{{0}, 0});
    draw_truth();
  }
  /// Five samples of the truth.
  void update(Trial& trial, Sum& sum) {
    for (int k = 0; k < updates; ++k) push(subject_.seen(truth_, random_), 1'100'000'000 + k * 100'000'000);
    if (!trial.expect(filter_.healthy(FilterId{0}), "the miniature filter breaks: ", filter_.diagnosis(FilterId{0})))
      return;
    const auto counts = filter_.counts(MeasurementId{{0}, 0});
    const auto accepted = counts.by_outcome[0] - before_.by_outcome[0];
    if (accepted < updates) {
      if (counts.by_outcome[static_cast<int>(Outcome::gated)] == 0)
        Trial::skip("the miniature filter does not accept its samples: " + counts.last_reason);
      ++sum.left_out;
      return;
    }
    sum.nis += counts.nis_mean * static_cast<double>(counts.by_outcome[0]) -
               (before_.by_outcome[0] ? before_.nis_mean * static_cast<double>(before_.by_outcome[0]) : 0.0);
    sum.dof += std::round(counts.dof_mean * static_cast<double>(accepted));
  }
  const Session& filter() const { return filter_; }

 private:
  /// The channel carries what has_field says, in the order of the spec.
  void push(const SampleNumbers& sample, Time t) {
    std::vector<double> carried;
    for (std::size_t i = 0; i < sample.epoch.size(); ++i)
      if (subject_.measurement.has_field[i]) carried.push_back(sample.epoch[i]);
    const auto& fields = subject_.measurement.part.type->spec.fields;
    const bool has_interval =
        std::ranges::any_of(fields, [](const FieldSpec& field) { return field.kind != FieldKind::level; });
    filter_.push(channel_, has_interval ? t - 10'000'000 : no_time, t, carried);  // as SampleNumbers::view() has it
  }
  void draw_truth() {
    const Eigen::VectorXd error = draw(filter_.covariance(FilterId{0}).as(), random_);
    const auto state = filter_.state(FilterId{0});
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      if (truth_[i].is_open()) continue;
      for (const auto& block : subject_.composition->filters().front().blocks) {
        if (block.name != subject_.measurement.part.ports[i].name) continue;
        const std::vector<double> from(state.begin() + block.stored_offset,
                                       state.begin() + block.stored_offset + block.declaration->stored_size);
        const Eigen::VectorXd delta = error.segment(block.first_row, truth_[i].dof());
        truth_[i].block->plus(from, delta, truth_[i].x);
      }
    }
  }

  const SeenSubject& subject_;
  std::mt19937_64 random_;
  Session filter_;
  ChannelId channel_;
  MeasurementCounts before_;
  PortStates truth_;
};

/// Whether one push of fields is all that the miniature filter needs.
bool is_plain(const ComponentSpec& spec) {
  return spec.driving_rates.empty() && spec.inputs.empty() &&
         std::none_of(spec.fields.begin(), spec.fields.end(), [](const auto& field) { return field.is_per_row; });
}

std::string text_of(const Sum& sum, int runs) {
  std::ostringstream text;
  text.precision(4);
  if (sum.dof > 0)
    text << "NIS is " << sum.mean() << " a degree of freedom over " << runs
         << " runs of a world that is the model itself; 99.98 % band " << sum.low() << " to " << sum.high();
  else
    text << "in a world that is the model itself no run of " << runs << " is without a gated sample";
  if (sum.left_out > 0) text << "; " << sum.left_out << " runs have a gated sample";
  return text.str();
}

}  // namespace

void measurement_consistency(Trial& trial) {
  const SeenSubject subject(trial);
  const int runs = trial.repeats(40);
  auto random = trial.random(19'999);
  const PortStates ports = subject.measurement.ports(random, 0.0);
  if (!is_plain(subject.measurement.part.type->spec)) {
    const Eigen::MatrixXd prior = prior_of(subject, ports, nullptr);
    const Sum sum = believe_often(trial, subject, prior, 1.0);
    if (!sum.is_inside()) judge(trial, subject, prior, text_of(sum, runs));
    return;
  }
  Sum sum;
  for (int number = 0; number < runs; ++number) {
    MeasurementRun run(subject, trial.random(20'000 + static_cast<std::uint64_t>(number)));
    run.update(trial, sum);
    if (!run.filter().healthy(FilterId{0})) return;
  }
  // A sample in a thousand is gated by design, and its run left out.
  if (sum.is_inside() && sum.left_out <= 1 + runs / 20) return;
  const MeasurementRun started(subject, trial.random(20'000));
  judge(trial, subject, prior_of(subject, ports, &started.filter()), text_of(sum, runs));
}

}  // namespace binnacle::conform
