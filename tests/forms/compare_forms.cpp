// SPDX-License-Identifier: Apache-2.0
// Runs a config in each form of the covariance, and writes into FOLDER/forms.json how far `ud` and `square_root` are from `joseph`:
// `compare_forms run CONFIG --out FOLDER [--var NAME=VALUE] [--set PATCH]`, as the command is called. Exit status 3: the
// config does not load.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/composition.hpp"
#include "binnacle/diagnostic.hpp"
#include "binnacle/run.hpp"
#include "binnacle/state_block.hpp"

using namespace binnacle;
using Json = nlohmann::json;

namespace {

struct Sample {
  Time t = 0;
  int measurement = 0, rows = 0, left_out = 0;
  Outcome outcome = Outcome::late;
  double nis = 0;
  std::vector<double> x, sigma;  // where it was accepted
};

/// Every sample of one filter, and its state after each that was accepted.
class Trace final : public StepObserver {
 public:
  explicit Trace(const FilterInfo& info) : info_(info) {}
  Wants wants() const override { return Wants::update_covariance; }
  void offered(const UpdateRecord& record) override {
    Sample& sample = samples.emplace_back(
        Sample{record.t, record.measurement, record.rows, record.left_out, record.outcome, record.nis, {}, {}});
    if (record.outcome != Outcome::accepted) return;
    sample.x.assign(record.x1, record.x1 + info_.stored_size);
    for (int i = 0; i < info_.dof; ++i) sample.sigma.push_back(std::sqrt(record.P1(i, i)));
  }
  std::vector<Sample> samples;
  bool is_healthy = true;

 private:
  const FilterInfo& info_;
};

class Traces final : public RunObserver {
 public:
  void begin(Session& session) override {
    session_ = &session;
    for (const auto& info : session.composition().filters()) {
      all.push_back(std::make_unique<Trace>(info));
      session.attach({static_cast<int>(all.size()) - 1}, all.back().get());
    }
  }
  void finished() override {
    for (std::size_t f = 0; f < all.size(); ++f) all[f]->is_healthy = session_->healthy({static_cast<int>(f)});
  }
  std::vector<std::unique_ptr<Trace>> all;

 private:
  Session* session_ = nullptr;
};

/// The largest difference so far, and where it is.
struct Largest {
  double value = 0;
  std::string where;
  void note(double found, const std::string& filter, const std::string& component, Time t) {
    if (found <= value) return;
    value = std::isnan(found) ? std::numeric_limits<double>::infinity() : found;
    where = filter + "/" + component + " at " + std::to_string(seconds(t)) + " s";
  }
};

struct Difference {
  Largest estimates, sigmas;  // in sigma; relative
  int samples = 0, different = 0;
  std::string first;  // sample whose outcome, or rows, are not the same
  int stopped = 0;    // filters of which one form went on and the other did not

  Json json() const {
    return {{"estimates", estimates.value}, {"estimates_at", estimates.where},
            {"sigmas", sigmas.value},       {"sigmas_at", sigmas.where},
            {"compared", samples},          {"samples", different},
            {"samples_at", first},          {"stopped", stopped}};
  }
};

void compare_states(const FilterInfo& info, const Sample& one, const Sample& other, Difference& found) {
  std::vector<double> delta;
  for (const auto& block : info.blocks) {
    const int size = block.declaration->stored_size;
    delta.assign(block.use.size(), 0.0);
    block.block->minus({other.x.data() + block.stored_offset, size}, {one.x.data() + block.stored_offset, size},
                       {delta.data(), static_cast<int>(delta.size())});
    for (std::size_t a = 0; a < block.active.size(); ++a) {
      const auto component = static_cast<std::size_t>(block.active[a]);
      const auto row = static_cast<std::size_t>(block.first_row) + a;
      const std::string name = block.name + "." + block.declaration->error[component].name;
      const double sigma = one.sigma[row], off = std::abs(delta[component]);
      // What is known exactly may be off by rounding.
      constexpr double rounding = 1e-12;
      if (sigma > 0 || off > rounding) found.estimates.note(off / sigma, info.name, name, one.t);
      if (sigma > 0 || other.sigma[row] > rounding)
        found.sigmas.note(std::abs(other.sigma[row] / sigma - 1), info.name, name, one.t);
    }
  }
}

void compare(const FilterInfo& info, const Trace& one, const Trace& other, Difference& found) {
  found.stopped += one.is_healthy != other.is_healthy;
  const std::size_t count = std::min(one.samples.size(), other.samples.size());
  found.samples += static_cast<int>(count);
  found.different += static_cast<int>(std::max(one.samples.size(), other.samples.size()) - count);
  for (std::size_t i = 0; i < count; ++i) {
    const Sample &a = one.samples[i], &b = other.samples[i];
    const bool is_same = a.t == b.t && a.measurement == b.measurement && a.outcome == b.outcome && a.rows == b.rows &&
                         a.left_out == b.left_out;
    if (!is_same && found.different++ == 0)
      found.first = info.name + "/" + info.measurements[static_cast<std::size_t>(a.measurement)].name + " at " +
                    std::to_string(seconds(a.t)) + " s, NIS " + std::to_string(a.nis);
    if (a.outcome == Outcome::accepted && b.outcome == Outcome::accepted && a.t == b.t)
      compare_states(info, a, b, found);
  }
}

std::unique_ptr<Traces> run_in(const char* form, const std::string& config, LoadOptions options,
                               std::shared_ptr<const Composition>& composition) {
  composition = Composition::load(config, options);
  for (const auto& filter : composition->filters())
    options.sets.push_back("/filters/" + filter.name + "/covariance=" + form);
  composition = Composition::load(config, options);
  auto traces = std::make_unique<Traces>();
  RunOptions run_options;
  run_options.observer = traces.get();
  run(composition, run_options);
  return traces;
}

int compare_all(const std::string& config, const LoadOptions& options, const std::string& folder) {
  std::shared_ptr<const Composition> composition;
  const auto joseph = run_in("joseph", config, options, composition);
  Json json;
  for (const char* form : {"ud", "square_root"}) {
    const auto other = run_in(form, config, options, composition);
    Difference found;
    for (std::size_t f = 0; f < joseph->all.size(); ++f)
      compare(composition->filters()[f], *joseph->all[f], *other->all[f], found);
    json[form] = found.json();
  }
  std::ofstream(folder + "/forms.json") << json.dump(2) << "\n";
  return 0;
}

}  // namespace

int main(int count, char* arguments[]) {
  ::setenv("BINNACLE_PLUGIN_PATH", BINNACLE_TEST_PLUGINS, 1);
  LoadOptions options;
  std::string config, folder = ".";
  for (int i = 2; i < count; ++i) {
    const std::string word = arguments[i];
    const auto next = [&] { return std::string(i + 1 < count ? arguments[++i] : ""); };
    if (word == "--set") {
      options.sets.push_back(next());
    } else if (word == "--var") {
      const std::string text = next();
      options.vars[text.substr(0, text.find('='))] = text.substr(text.find('=') + 1);
    } else if (word == "--out") {
      folder = next();
    } else {
      config = word;
    }
  }
  try {
    return compare_all(config, options, folder);
  } catch (const ConfigError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
