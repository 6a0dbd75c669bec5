// SPDX-License-Identifier: Apache-2.0
#include "covariance/analysis.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <Eigen/Cholesky>

#include "binnacle/filter.hpp"
#include "joint_covariance.hpp"
#include "plan.hpp"
#include "study/section.hpp"
#include "study/summary.hpp"

namespace binnacle::covariance {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Json = nlohmann::ordered_json;

constexpr double settled_within = 0.01;  // of the final value
constexpr double settled_before = 0.9;   // of the duration; what comes to rest later has not been seen to

MatrixXd copied(MatrixView view) { return view.as(); }

/// One filter's matrices, in the order in which things happened since they were last taken.
class Recorder final : public StepTape {
 public:
  struct Event {
    enum Kind { started, stepped, offered } kind = started;
    Time t = 0;
    MatrixXd P0, P1, Phi, S, R, H;
    int measurement = 0;
    Outcome outcome = Outcome::rejected;
    std::string reason;
  };

  bool wants_matrices() const override { return true; }
  void started(Time t, const double* /*x*/, MatrixView P) override {
    Event event;
    event.t = t;
    event.P1 = copied(P);
    events_.push_back(std::move(event));
  }
  void stepped(const StepRecord& record) override {
    Event event;
    event.kind = Event::stepped;
    event.t = record.t1;
    event.P0 = copied(record.P0);
    event.P1 = copied(record.P1);
    event.Phi = copied(record.Phi);
    events_.push_back(std::move(event));
  }
  void offered(const UpdateRecord& record) override {
    Event event;
    event.kind = Event::offered;
    event.t = record.t;
    event.measurement = record.measurement;
    event.outcome = record.outcome;
    event.reason = record.reason;
    if (record.H) {
      event.S = copied(record.S);
      event.R = copied(record.R);
      event.H = copied(record.H);
    }
    events_.push_back(std::move(event));
  }
  std::vector<Event> take() { return std::exchange(events_, {}); }

 private:
  std::vector<Event> events_;
};

using Event = Recorder::Event;

/// Thrown where a variant cannot be analysed to its end.
struct Broken : std::runtime_error {
  using std::runtime_error::runtime_error;
};

int row_of(const FilterInfo& info, const std::string& block, const std::string& component) {
  for (const auto& entry : info.blocks) {
    if (entry.name != block) continue;
    for (std::size_t a = 0; a < entry.active.size(); ++a)
      if (entry.declaration->error[static_cast<std::size_t>(entry.active[a])].name == component || component.empty())
        return entry.first_row + static_cast<int>(a);
  }
  return -1;
}

/// Columns of H that belong to the block, set to zero.
MatrixXd without(MatrixXd H, const FilterInfo& info, const std::string& block) {
  for (const auto& entry : info.blocks)
    if (entry.name == block) H.middleCols(entry.first_row, static_cast<Eigen::Index>(entry.active.size())).setZero();
  return H;
}

struct Point {
  double t = 0, variance = 0, own_variance = 0;
};

/// What is told over time: one error component, or one reading output.
struct Subject {
  std::string name;
  const ReadingOutput* output = nullptr;
  int true_row = -1, model_row = -1;
  std::vector<Point> points;
  VectorXd parts;                  // the newest variance by source
  std::vector<std::string> names;  // of the sources then
};

class Run {
 public:
  Run(const Plan& plan, const std::vector<std::string>& names)
      : plan_(plan),
        info_(plan.model->filters()[static_cast<std::size_t>(plan.filter)]),
        true_info_(plan.truth->filters()[static_cast<std::size_t>(plan.filter)]),
        joint_(true_info_, info_),
        model_(plan.model) {
    model_.attach(plan.filter, &recorder_);
    if (plan.truth != plan.model) {
      truth_.emplace(plan.truth);
      truth_->attach(plan.filter, &true_recorder_);
    }
    for (const auto& name : names) add_subject(name);
  }

  void carry_out() {
    std::vector<Time> next;
    for (const auto& feed : plan_.feeds) next.push_back(feed.is_of_intervals ? feed.interval : 0);
    while (!next.empty()) {
      const Time t = *std::min_element(next.begin(), next.end());
      if (t > plan_.duration) break;
      feed(model_, next, t);
      if (truth_) feed(*truth_, next, t);
      for (std::size_t i = 0; i < next.size(); ++i)
        if (next[i] == t) next[i] += plan_.feeds[i].interval;
      if (!model_.healthy(plan_.filter)) throw Broken(model_.diagnosis(plan_.filter));
      follow(t);
    }
  }

  const std::vector<Subject>& subjects() const { return subjects_; }

 private:
  void add_subject(const std::string& name) {
    Subject subject;
    subject.name = name;
    for (const auto& output : plan_.outputs)
      if (output.name == name) subject.output = &output;
    if (!subject.output) {
      const auto dot = name.find('.');
      const std::string block = name.substr(0, dot), component = dot == std::string::npos ? "" : name.substr(dot + 1);
      subject.model_row = row_of(info_, block, component);
      subject.true_row = row_of(true_info_, block, component);
      if (subject.model_row < 0) throw Broken("'" + name + "' is neither estimated nor considered: it has no variance");
    }
    subjects_.push_back(std::move(subject));
  }

  void feed(Filter& filter, const std::vector<Time>& next, Time t) {
    for (std::size_t i = 0; i < next.size(); ++i) {
      if (next[i] != t) continue;
      const Feed& feed = plan_.feeds[i];
      SampleView sample;
      sample.t = t;
      if (feed.is_of_intervals) sample.t0 = t - feed.interval;
      sample.fields = feed.values.data();
      filter.add(filter.channel(feed.channel), sample);
    }
    filter.commit(t);
  }

  /// Takes what both filters did in this instant into the joint covariance.
  void follow(Time t) {
    const auto events = recorder_.take();
    const auto true_events = truth_ ? true_recorder_.take() : std::vector<Event>{};
    std::size_t j = 0;
    for (const auto& event : events) {
      const Event* truth = &event;
      if (truth_) {
        while (j < true_events.size() && !is_alike(event, true_events[j])) ++j;
        if (j == true_events.size()) throw Broken("the truth has no step or measurement where the filter has one");
        truth = &true_events[j++];
      }
      take(event, *truth);
    }
    if (is_started_) note_blocks(t);
  }

  bool is_alike(const Event& event, const Event& truth) const {
    return event.kind == truth.kind && event.t == truth.t &&
           (event.kind != Event::offered || info_.measurements[static_cast<std::size_t>(event.measurement)].name ==
                                                true_info_.measurements[static_cast<std::size_t>(truth.measurement)].name);
  }

  void take(const Event& event, const Event& truth) {
    switch (event.kind) {
      case Event::started:
        P_ = event.P1;
        joint_.start(truth.P1);
        is_started_ = true;
        break;
      case Event::stepped:
        P_ = event.P1;
        joint_.step(truth.Phi, process_noise(truth), event.Phi);
        break;
      case Event::offered: measure(event, truth);
    }
  }

  /// The tape has Φ and P on both sides of a step: what is over is noise, to within rounding.
  static MatrixXd process_noise(const Event& event) {
    constexpr double rounding = 1e-14;
    MatrixXd Q = event.P1 - event.Phi * event.P0 * event.Phi.transpose();
    for (Eigen::Index j = 0; j < Q.cols(); ++j)
      for (Eigen::Index i = 0; i < Q.rows(); ++i)
        if (std::abs(Q(i, j)) <= rounding * std::sqrt(event.P1(i, i) * event.P1(j, j))) Q(i, j) = 0;
    return 0.5 * (Q + Q.transpose());
  }

  void measure(const Event& event, const Event& truth) {
    const std::string& name = info_.measurements[static_cast<std::size_t>(event.measurement)].name;
    const bool is_seen = event.outcome == Outcome::accepted || event.outcome == Outcome::withheld;
    if (!is_seen) throw Broken("measurement '" + name + "' was not accepted: " + event.reason);
    if (truth.H.rows() != event.H.rows()) throw Broken("measurement '" + name + "' has other rows in the truth");
    note_readings(name, event, truth);
    if (event.outcome == Outcome::withheld) return;
    MatrixXd K = event.S.llt().solve(event.H * P_).transpose();
    for (const auto& block : info_.blocks)
      for (std::size_t a = 0; a < block.active.size(); ++a)
        if (block.use[static_cast<std::size_t>(block.active[a])] == "considered")
          K.row(block.first_row + static_cast<Eigen::Index>(a)).setZero();
    const MatrixXd A = MatrixXd::Identity(info_.dof, info_.dof) - K * event.H;
    P_ = (A * P_ * A.transpose() + K * event.R * K.transpose()).eval();
    joint_.update(name, truth.H, truth.R, event.H, K);
  }

  void note(Subject& subject, Time t, const VectorXd& c, double own_variance, int extra_source, double extra) {
    subject.parts = joint_.variance(c);
    if (extra_source >= 0) subject.parts[extra_source] += extra;
    subject.names = joint_.sources();
    const Point point{seconds(t), subject.parts.sum(), own_variance};
    if (!subject.points.empty() && subject.points.back().t == point.t)
      subject.points.back() = point;
    else
      subject.points.push_back(point);
  }

  void note_blocks(Time t) {
    for (auto& subject : subjects_) {
      if (subject.output) continue;
      VectorXd c = VectorXd::Zero(joint_.true_size() + joint_.model_size());
      if (subject.true_row >= 0) c[subject.true_row] = 1;
      c[joint_.true_size() + subject.model_row] = -1;
      note(subject, t, c, P_(subject.model_row, subject.model_row), -1, 0);
    }
  }

  /// z − h(x̂) without the wanted block: its error is what is true of the rest, less what the filter holds of it, and v.
  /// Before the update: the estimate does not know v yet.
  void note_readings(const std::string& measurement, const Event& event, const Event& truth) {
    for (auto& subject : subjects_) {
      if (!subject.output || subject.output->measurement != measurement) continue;
      const MatrixXd rest = without(event.H, info_, subject.output->block);
      const MatrixXd true_rest = without(truth.H, true_info_, subject.output->block);
      Eigen::Index row = 0;
      while (row < event.H.rows() && event.H.row(row) == rest.row(row)) ++row;
      if (row == event.H.rows())
        throw Broken("measurement '" + measurement + "' sees nothing of '" + subject.output->block + "'");
      VectorXd c(joint_.true_size() + joint_.model_size());
      c << true_rest.row(row).transpose(), -rest.row(row).transpose();
      const double own = (rest.row(row) * P_ * rest.row(row).transpose())(0) + event.R(row, row);
      const int source = joint_.source("noise of " + measurement);
      note(subject, event.t, c, own, source, truth.R(row, row));
    }
  }

  const Plan& plan_;
  const FilterInfo& info_;
  const FilterInfo& true_info_;
  JointCovariance joint_;
  Filter model_;
  std::optional<Filter> truth_;
  Recorder recorder_, true_recorder_;
  MatrixXd P_;
  bool is_started_ = false;
  std::vector<Subject> subjects_;
};

double figure_of(const Request& request, const std::vector<Point>& points, Time duration) {
  if (points.empty()) return std::nan("");
  if (request.statistic == Statistic::settled) {
    const double last = std::sqrt(points.back().variance);
    double from = points.front().t;
    for (std::size_t i = points.size(); i-- > 0;)
      if (std::abs(std::sqrt(points[i].variance) - last) > settled_within * last) {
        from = i + 1 < points.size() ? points[i + 1].t : points[i].t;
        break;
      }
    return from > settled_before * seconds(duration) ? std::nan("") : from;
  }
  const Point* point = &points.back();
  if (request.at != no_time) {
    const auto after = std::find_if(points.begin(), points.end(),
                                    [at = seconds(request.at)](const Point& p) { return p.t > at + 1e-9; });
    if (after == points.begin()) return std::nan("");
    point = &*(after - 1);
  }
  return std::sqrt(std::max(0.0, request.statistic == Statistic::sigma ? point->variance : point->own_variance));
}

LoadOptions options_of(const LoadOptions& options, const study::Variant& variant) {
  LoadOptions load = options;
  load.patches = variant.patches;
  return load;
}

}  // namespace

bool is_in(const Config& config) { return config.root().contains("covariance"); }

study::Study load(const std::filesystem::path& path, const LoadOptions& options) {
  study::StudyOptions study_options;
  study_options.load = options;
  study_options.section = "/covariance";
  study_options.read_metric = read_metric;
  study_options.runs = 1;
  auto study = study::Study::load(path, study_options);
  Diagnostics diagnostics;
  for (const auto& variant : study.variants()) {
    Diagnostics own;
    read_plan(Config::load(path, options_of(options, variant)), path, variant.composition, own);
    if (own.has_errors()) {
      diagnostics.merge(own);
      break;  // the others would mostly say the same
    }
  }
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  return study;
}

Json analyse(const study::Study& study, const std::filesystem::path& path, const LoadOptions& options) {
  study::Results results(study.variants().size(), 1);
  std::vector<Json> budgets(study.variants().size(), Json::object());
  for (std::size_t v = 0; v < study.variants().size(); ++v) {
    const auto& variant = study.variants()[v];
    auto& figures = results.at(v, 0);
    figures.values.assign(study.metrics().size(), MetricValue{std::nan(""), 0, 0});
    Diagnostics diagnostics;
    const Plan plan =
        read_plan(Config::load(path, options_of(options, variant)), path, variant.composition, diagnostics);
    if (diagnostics.has_errors()) throw ConfigError(diagnostics);
    const std::string& filter = variant.composition->filters()[static_cast<std::size_t>(plan.filter)].name;
    std::vector<std::string> names;
    for (const auto& metric : variant.metrics) {
      const auto request = request_of(metric.name);
      if (metric.filter == plan.filter && std::find(names.begin(), names.end(), request.name) == names.end())
        names.push_back(request.name);
    }
    try {
      Run run(plan, names);
      run.carry_out();
      for (std::size_t m = 0; m < study.metrics().size(); ++m) {
        if (variant.position[m] < 0) continue;
        const auto request = request_of(study.metrics()[m].name);
        for (const auto& subject : run.subjects())
          if (subject.name == request.name) figures.values[m].value = figure_of(request, subject.points, plan.duration);
      }
      for (const auto& subject : run.subjects()) {
        Json shares = Json::object();
        for (std::size_t s = 0; s < subject.names.size() && !subject.points.empty(); ++s)
          shares[subject.names[s]] = subject.parts[static_cast<Eigen::Index>(s)] / subject.points.back().variance;
        budgets[v][filter + "/" + subject.name] = std::move(shares);
      }
      figures.state = study::Figures::State::finished;
    } catch (const Broken& broken) {
      figures.state = study::Figures::State::failed;
      figures.failure = broken.what();
    }
  }
  Json summary = study::summarize(study, results);
  for (std::size_t v = 0; v < study.variants().size(); ++v)
    summary["variants"][study.variants()[v].name]["budget"] = std::move(budgets[v]);
  return summary;
}

}  // namespace binnacle::covariance
