// SPDX-License-Identifier: Apache-2.0
// How a study grows with threads and with ranks: `study_bench CONFIG [RUNS] [REPEATS]` prints times and memory of
// `binnacle study` with 1 to 8 threads, and under mpirun with 1 and 2 ranks of one thread each. The repeats of all go
// round in turn and the best of each counts, for a machine that has other things to do.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

struct Way {
  std::string name;
  std::vector<std::string> launcher;
  int jobs = 1, workers = 1;                       // threads of a process, and of all together
  double wall = 1e9, processor = 1e9, memory = 0;  // s, s, MB of the largest process
};

double seconds(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

double now() {
  timeval t{};
  gettimeofday(&t, nullptr);
  return seconds(t);
}

bool carry_out(Way& way, const std::string& config, const std::string& runs) {
  std::vector<std::string> words = way.launcher;
  for (const auto& word : {std::string(BENCH_COMMAND), std::string("study"), config, std::string("--runs"), runs,
                           std::string("--quiet"), std::string("--jobs"), std::to_string(way.jobs)})
    words.push_back(word);
  const double begin = now();
  const pid_t child = fork();
  if (child == 0) {
    setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
    setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};  // of all that it waited for, too
  wait4(child, &status, 0, &usage);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return false;
  way.wall = std::min(way.wall, now() - begin);
  way.processor = std::min(way.processor, seconds(usage.ru_utime) + seconds(usage.ru_stime));
  way.memory = std::max(way.memory, static_cast<double>(usage.ru_maxrss) / 1024);
  return true;
}

std::string load_average() {
  std::ifstream file("/proc/loadavg");
  std::string minute;
  file >> minute;
  return minute;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: study_bench CONFIG [RUNS] [REPEATS]\n");
    return 2;
  }
  const std::string config = argv[1], runs = argc > 2 ? argv[2] : "200";
  const int repeats = argc > 3 ? std::atoi(argv[3]) : 5;
  const std::vector<std::string> mpirun{"mpirun", "--oversubscribe", "-n"};
  const auto ranks = [&](const char* count) {
    auto words = mpirun;
    words.emplace_back(count);
    return words;
  };
  std::vector<Way> ways{{"1 thread", {}, 1, 1},
                        {"2 threads", {}, 2, 2},
                        {"4 threads", {}, 4, 4},
                        {"8 threads", {}, 8, 8}};
  const bool has_mpirun = std::system("mpirun --version >/dev/null 2>&1") == 0;
  if (has_mpirun) {
    ways.push_back({"1 rank", ranks("1"), 1, 1});
    ways.push_back({"2 ranks", ranks("2"), 1, 2});
  } else {
    std::printf("SKIPPED: no mpirun\n");
  }
  std::printf("%s, %s runs of each variant, best of %d; %u processors, load before %s\n", config.c_str(), runs.c_str(),
              repeats, std::thread::hardware_concurrency(), load_average().c_str());
  for (int i = 0; i < repeats; ++i)
    for (auto& way : ways)
      if (!carry_out(way, config, runs)) {
        std::fprintf(stderr, "%s: the study failed\n", way.name.c_str());
        return 1;
      }
  std::printf("%-10s %8s %9s %12s %9s %20s\n", "", "wall s", "speed-up", "processor s", "at most",
              "MB, largest process");
  for (const auto& way : ways) {
    // What the processor time would come to on processors that have nothing else to do.
    const int workers = std::min(way.workers, static_cast<int>(std::thread::hardware_concurrency()));
    std::printf("%-10s %8.2f %9.2f %12.2f %9.2f %20.1f\n", way.name.c_str(), way.wall, ways[0].wall / way.wall,
                way.processor, workers * ways[0].processor / way.processor, way.memory);
  }
  std::printf("a thread more: %.2f MB\n", (ways[3].memory - ways[0].memory) / 7);
  return 0;
}
