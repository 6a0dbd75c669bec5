// SPDX-License-Identifier: Apache-2.0
#include "live/run_page.hpp"

#include <utility>

#include "address.hpp"
#include "report/page.hpp"
#include "report/watched_run.hpp"
#include "server.hpp"

namespace binnacle::live {

namespace {

results::RunResults without_series(const Json& config, const Json& provenance) {
  results::RunResults run;
  run.summary = Json::object();
  run.config = config;
  run.provenance = provenance;
  return run;
}

}  // namespace

struct RunPage::Contents {
  Contents(const std::string& address, const Json& config, const Json& provenance)
      : about(std::make_shared<const results::RunResults>(without_series(config, provenance))),
        server(endpoint_of(address), report::live_page(*about)) {}

  /// Made by the server's thread: it takes longer than the run should wait.
  Server::Text payload_of(results::RunResults seen, bool is_over) const {
    return [about = about, seen = std::move(seen), is_over]() mutable {
      seen.config = about->config;
      seen.provenance = about->provenance;
      return report::live_payload(seen, is_over);
    };
  }

  std::shared_ptr<const results::RunResults> about;  // config and provenance
  std::unique_ptr<report::WatchedRun> run;
  results::RunResults at_the_end;
  Server server;
};

RunPage::RunPage(const std::string& address, const Json& config, const Json& provenance)
    : contents_(std::make_unique<Contents>(address, config, provenance)) {}

RunPage::~RunPage() = default;

std::string RunPage::url() const { return contents_->server.url(); }

void RunPage::begin_run(const Session& session) { contents_->run = std::make_unique<report::WatchedRun>(session); }

StepObserver* RunPage::step_observer(int filter, StepObserver* next) {
  return contents_->run->step_observer(filter, next);
}

void RunPage::after_instant() {
  const bool is_watched = contents_->server.is_watched();
  contents_->run->look(is_watched);
  if (!is_watched) return;
  contents_->run->take();
  if (contents_->server.asks()) contents_->server.publish(contents_->payload_of(contents_->run->seen(), false));
}

void RunPage::finished() {
  contents_->run->look(false);
  if (!contents_->server.is_watched()) return;
  contents_->at_the_end = contents_->run->seen();
  contents_->server.publish(contents_->payload_of(contents_->at_the_end, false));  // smoothing may take a while
}

void RunPage::conclude(const Json& summary) {
  contents_->at_the_end.summary = summary;
  contents_->server.publish_last(contents_->payload_of(std::move(contents_->at_the_end), true));
}

}  // namespace binnacle::live
