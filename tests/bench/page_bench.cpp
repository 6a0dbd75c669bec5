// SPDX-License-Identifier: Apache-2.0
// What `run --page` costs the run, as ratios to the run without a page in the same process: `page_bench [INSTANTS] [ROUNDS]`.
// The run's thread is timed by its own processor time, so that neighbours on the machine matter less.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <netinet/in.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "live/run_page.hpp"
#include "score/run.hpp"
#include "score/sections.hpp"

using namespace binnacle;

namespace {

/// The quickstart's filter, 15 states at 100 Hz, at rest for so many samples of its IMU.
std::shared_ptr<const Composition> rest(const std::string& instants) {
  ::setenv("BINNACLE_PLUGIN_PATH", BENCH_PLUGINS, 1);
  LoadOptions options;
  options.sets = {R"(/sources/drive/segments=[{"do": "still", "duration": ")" +
                      std::to_string(std::stod(instants) / 100) + R"( s"}])",
                  "/sources/drive/truth_rate=0", "/reference=[]"};
  return score::load(BENCH_PROJECT "/configs/quickstart.json", options);
}

double now(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

class Shown final : public score::RunObserver {
 public:
  Shown(live::RunPage* page, bool is_timed) : page_(page), is_timed_(is_timed) {}
  bool wants_records() const override { return false; }
  void begin_run(const Session& session) override {
    if (page_) page_->begin_run(session);
  }
  StepObserver* step_observer(int filter) override { return page_ ? page_->step_observer(filter, nullptr) : nullptr; }
  void after_instant() override {
    if (!page_) return;
    const double begin = is_timed_ ? now(CLOCK_THREAD_CPUTIME_ID) : 0;
    page_->after_instant();
    if (is_timed_) longest = std::max(longest, now(CLOCK_THREAD_CPUTIME_ID) - begin);
  }
  void finished() override {
    if (page_) page_->finished();
  }

  double longest = 0;

 private:
  live::RunPage* page_;
  bool is_timed_;
};

/// Takes events as fast as they come.
class Viewer {
 public:
  explicit Viewer(const std::string& url) {
    const auto port = static_cast<std::uint16_t>(std::stoi(url.substr(url.rfind(':') + 1)));
    socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const std::string request = "GET /events HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n\r\n";
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
        ::send(socket_, request.data(), request.size(), 0) < 0)
      std::exit(1);
    char first = 0;
    if (::recv(socket_, &first, 1, 0) != 1) std::exit(1);  // it is seen now
    thread_ = std::thread([this] { read(); });
  }
  ~Viewer() {
    thread_.join();
    ::close(socket_);
  }

  static inline double events = 0, bytes = 0;

 private:
  void read() {
    std::vector<char> buffer(1 << 20);
    char last = 0;
    events -= 1;  // "retry"
    for (;;) {
      const auto count = ::recv(socket_, buffer.data(), buffer.size(), 0);
      if (count <= 0) return;
      bytes += static_cast<double>(count);
      for (long i = 0; i < count; ++i) {
        const char c = buffer[static_cast<std::size_t>(i)];
        events += c == '\n' && last == '\n';
        last = c;
      }
    }
  }

  int socket_ = -1;
  std::thread thread_;
};

enum Mode { without, unseen, seen, modes };

struct Times {
  double processor, wall, longest;
};

Times run(const std::shared_ptr<const Composition>& composition, Mode mode, bool is_timed = false) {
  std::unique_ptr<Viewer> viewer;
  const auto page =
      mode == without ? nullptr : std::make_unique<live::RunPage>("0", live::Json::object(), live::Json::object());
  if (mode == seen) viewer = std::make_unique<Viewer>(page->url());
  Shown shown(page.get(), is_timed);
  score::RunOptions options;
  options.observer = &shown;
  const double processor = now(CLOCK_THREAD_CPUTIME_ID), wall = now(CLOCK_MONOTONIC);
  const auto result = score::run(composition, options);
  const Times times{now(CLOCK_THREAD_CPUTIME_ID) - processor, now(CLOCK_MONOTONIC) - wall, shown.longest};
  if (page) page->conclude(result.summary);
  return times;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const std::string instants = argc > 1 ? argv[1] : "1000000";
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 7;
  const auto composition = rest(instants);
  std::vector<double> wall[modes], processor[modes], ratio[modes];
  for (int round = 0; round < rounds; ++round) {
    Times times[modes];
    for (const Mode mode : {without, unseen, seen}) {
      times[mode] = run(composition, mode);
      wall[mode].push_back(times[mode].wall);
      processor[mode].push_back(times[mode].processor);
      ratio[mode].push_back(times[mode].processor / times[without].processor);
    }
  }
  std::printf("%s instants, medians of %d rounds\n", instants.c_str(), rounds);
  const char* const names[] = {"without a page", "a page that nobody looks at", "a page with one viewer"};
  for (const Mode mode : {without, unseen, seen})
    std::printf("  %-28s %7.3f s of the clock, %7.3f s of the run's thread, ratio %.4f\n", names[mode],
                median(wall[mode]), median(processor[mode]), median(ratio[mode]));
  std::printf("  the page took no more than %.3f ms of the run's thread after any instant\n",
              1e3 * run(composition, seen, true).longest);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("  the viewer got %.1f events a run, %.0f kB each; peak memory %.0f MB\n", Viewer::events / (rounds + 1),
              Viewer::bytes / Viewer::events / 1e3, static_cast<double>(usage.ru_maxrss) / 1024);
}
