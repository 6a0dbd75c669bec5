// SPDX-License-Identifier: Apache-2.0
// binnacle study under mpirun: the files are those of one process, whatever dies on the way. Without mpirun, or where
// the command was built without MPI, these are skipped.
#include "catch.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "command.hpp"
#include "drive_study.hpp"
#include "skip.hpp"

namespace mpi_test {

using namespace binnacle::test;
namespace fs = std::filesystem;

namespace {

bool is_on_path(const std::string& program) {
  std::istringstream path(std::getenv("PATH") ? std::getenv("PATH") : "");
  for (std::string folder; std::getline(path, folder, ':');)
    if (fs::exists(fs::path(folder) / program)) return true;
  return false;
}

bool has_mpi() {
  const bool has = fs::exists(BINNACLE_TEST_PLUGINS "/mpi/binnacle_mpi.so") && is_on_path("mpirun");
  if (const char* ci = std::getenv("CI"); !has && ci && std::string(ci) == "true")
    FAIL("no MPI, though CI installs it");
  if (!has) binnacle::test::skip("no MPI (Debian packages libopenmpi-dev, openmpi-bin)");
  return has;
}

/// As root, with more ranks than processors, and with the sanitizers' eyes shut to what MPI itself leaves behind.
Start mpirun(std::vector<std::string> options) {
  Start start;
  start.launcher = {"mpirun", "--oversubscribe"};
  start.launcher.insert(start.launcher.end(), options.begin(), options.end());
  start.environment = {{"OMPI_ALLOW_RUN_AS_ROOT", "1"},
                       {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"},
                       {"OMPI_MCA_btl",
                        "^tcp"},  // Open MPI 5 complains of a machine's network, which no rank here needs
                       {"ASAN_OPTIONS", "detect_leaks=0"}};
  return start;
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string file_of_process(const std::string& id, const char* name) {
  std::ifstream file("/proc/" + id + "/" + name, std::ios::binary);
  std::ostringstream read;
  read << file.rdbuf();  // what can be read: a process may end meanwhile
  std::string text = read.str();
  std::replace(text.begin(), text.end(), '\0', '\n');  // between variables of the environment
  return text;
}

/// The process that mpirun started as this rank; 0: none.
int process_of(int mpirun, int rank) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string id = entry.path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    if (has(file_of_process(id, "status"), "\nPPid:\t" + std::to_string(mpirun) + "\n") &&
        has(file_of_process(id, "environ"), "\nOMPI_COMM_WORLD_RANK=" + std::to_string(rank) + "\n"))
      return std::stoi(id);
  }
  return 0;
}

/// Not for long: what was killed may still be on its way out.
bool is_alive_after_a_while(int process) {
  for (int i = 0; i < 1000; ++i) {
    const std::string status = file_of_process(std::to_string(process), "status");
    if (status.empty() || has(status, "\nState:\tZ")) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

void wait_for_lines(Command& running, const std::string& journal, std::size_t lines) {
  while (running.is_running() && lines_in(journal) < lines) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

}  // namespace

TEST_CASE("mpirun -n 2 and 3, --jobs 1 and 2 leave the same files") {
  if (!has_mpi()) return;
  const Workbench bench;
  write_drive(bench);
  REQUIRE(binnacle::test::binnacle(bench, {"study", "drive.json", "--jobs", "1", "--out", "one"}).status == 0);
  REQUIRE(binnacle::test::binnacle(bench, {"study", "drive.json", "--jobs", "2", "--out", "two"}).status == 0);
  check_same_files(bench, "one", "two");
  const auto ranks =
      binnacle::test::binnacle(bench, {"study", "drive.json", "--jobs", "1", "--out", "ranks"}, mpirun({"-n", "2"}));
  INFO(ranks.err);
  REQUIRE(ranks.status == 0);
  CHECK(ranks.err == "2 ranks, 2 threads; after an interruption, the same command continues it\n");
  CHECK(has(ranks.out, "24 runs, seed 7, wall time "));
  CHECK(ranks.out.find("24 runs") == ranks.out.rfind("24 runs"));  // only one of them prints
  check_same_files(bench, "one", "ranks");
  const auto both = binnacle::test::binnacle(bench, {"study", "drive.json", "--jobs", "2", "--out", "both", "--quiet"},
                                             mpirun({"-n", "3"}));
  REQUIRE(both.status == 0);
  CHECK(both.out.empty());
  check_same_files(bench, "one", "both");
}

TEST_CASE("a rank that was killed ends the study, and the same command continues it") {
  if (!has_mpi()) return;
  const Workbench bench;
  write_drive(bench);
  const std::vector<std::string> words{"study", "drive.json", "--runs", "40", "--jobs", "1", "--out"};
  const auto with = [&](const std::string& folder) {
    auto all = words;
    all.push_back(folder);
    return all;
  };
  REQUIRE(binnacle::test::binnacle(bench, with("whole")).status == 0);
  for (const int rank : {1, 0}) {
    const std::string folder = "cut" + std::to_string(rank), journal = bench.path(folder + "/study.journal");
    Command running(bench, with(folder), mpirun({"-n", "2"}));
    wait_for_lines(running, journal, 2);
    const int victim = process_of(running.id(), rank);
    REQUIRE(victim > 0);
    wait_for_lines(running, journal, 20);
    kill(victim, SIGKILL);
    const auto outcome = running.wait();
    INFO(outcome.err);
    CHECK(outcome.status == 128 + SIGKILL);
    CHECK(has(outcome.err, "process rank " + std::to_string(rank)));  // mpirun's words
    CHECK(has(outcome.err, "; after an interruption, the same command continues it\n"));
    CHECK_FALSE(fs::exists(bench.path(folder + "/study.csv")));
    CHECK(lines_in(journal) < 161);
    const auto rest = binnacle::test::binnacle(bench, with(folder), rank == 1 ? mpirun({"-n", "2"}) : Start{});
    REQUIRE(rest.status == 0);
    CHECK(has(rest.err, " of 160 runs are in the journal\n"));
    check_same_files(bench, "whole", folder);
    CHECK(lines_in(journal) == 161);
  }
}

TEST_CASE("mpirun that gets SIGTERM stops all ranks, and the study goes on later") {
  if (!has_mpi()) return;
  const Workbench bench;
  write_drive(bench);
  const auto words = [](const char* runs, const char* folder) {
    return std::vector<std::string>{"study", "drive.json", "--runs", runs, "--jobs", "1", "--out", folder};
  };
  Command running(bench, words("500", "out"), mpirun({"-n", "2"}));  // far more than there will be time for
  wait_for_lines(running, bench.path("out/study.journal"), 2);
  const int other = process_of(running.id(), 1);
  REQUIRE(other > 0);
  wait_for_lines(running, bench.path("out/study.journal"), 20);
  running.signal(SIGTERM);
  const auto outcome = running.wait();
  INFO(outcome.err);
  CHECK(outcome.status != 0);
  CHECK(has(outcome.err, "the same command continues it\n"));
  CHECK_FALSE(is_alive_after_a_while(other));
  CHECK_FALSE(fs::exists(bench.path("out/study.csv")));
  const auto rest = binnacle::test::binnacle(bench, words("8", "out"), mpirun({"-n", "2"}));
  REQUIRE(rest.status == 0);
  CHECK(has(rest.err, " of 32 runs are in the journal\n"));
  REQUIRE(binnacle::test::binnacle(bench, words("8", "whole")).status == 0);
  check_same_files(bench, "whole", "out");
}

TEST_CASE("ranks that would not do the same study are refused, and rank 0 says why") {
  if (!has_mpi()) return;
  const Workbench bench;
  write_drive(bench);
  // By a shell: Open MPI 5.0.7 crashes where a command line has two programs.
  const auto refused = binnacle::test::binnacle(bench, {"study", "drive.json", "--out", "out"},
                                                mpirun({"-n", "2", "sh", "-c",
                                                        "exec \"$0\" \"$@\" --seed $((7 + OMPI_COMM_WORLD_RANK))"}));
  CHECK(refused.status == 2);
  CHECK(has(refused.err, "error: its seed is another than that of rank 0\n"));
  CHECK_FALSE(fs::exists(bench.path("out")));
  const auto wrong = binnacle::test::binnacle(bench, {"study", "nowhere.json"}, mpirun({"-n", "2"}));
  CHECK(wrong.status == 3);
  CHECK(has(wrong.err, "error[B003]"));
  CHECK(wrong.err.find("B003") == wrong.err.rfind("B003"));
}

TEST_CASE("a rank that is stopped, at whatever moment, ends the study in the stated time with a message") {
  if (!has_mpi()) return;
  const Workbench bench;
  write_drive(bench);
  for (const int rank : {1, 0})
    for (const int delay_ms : {0, 100, 200, 300, 500, 800}) {
      INFO("rank " << rank << " after " << delay_ms << " ms");
      Start start = mpirun({"-n", "2"});
      start.environment["BINNACLE_MPI_TIMEOUT"] = "2";
      Command running(bench, {"study", "drive.json", "--runs", "5000", "--jobs", "1", "--quiet"}, start);
      int victim = 0;
      while (running.is_running() && victim == 0) victim = process_of(running.id(), rank);
      REQUIRE(victim > 0);
      std::this_thread::sleep_for(std::chrono::milliseconds(delay_ms));
      kill(victim, SIGSTOP);
      const auto begin = std::chrono::steady_clock::now();
      const auto outcome = running.wait();
      CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(30));
      INFO(outcome.err);
      CHECK(outcome.status != 0);
      const bool is_named = has(outcome.err, "no message for 2 s, so it is considered dead");
      const bool is_joining = has(outcome.err, "error: the ranks did not connect to each other within 2 s");
      CHECK((is_named || is_joining));
      if (is_named) CHECK(has(outcome.err, "rank " + std::to_string(rank)));
      CHECK_FALSE(is_alive_after_a_while(victim));
    }
}

TEST_CASE("a time-out that is no number of seconds is refused") {
  const Workbench bench;
  for (const char* text : {"soon", "0", "-1", "nan", "1e9"}) {
    Start start;
    start.environment["BINNACLE_MPI_TIMEOUT"] = text;
    const auto outcome = binnacle::test::binnacle(bench, {"study", "good.json"}, start);
    CHECK(outcome.status == 2);
    CHECK(has(outcome.err, std::string("error: BINNACLE_MPI_TIMEOUT takes 1 to 86400 seconds; found '") + text + "'"));
  }
}

TEST_CASE("the Slurm script of the guide carries out a study") {
  if (!has_mpi()) return;
  const Workbench bench;
  write_drive(bench);
  REQUIRE(binnacle::test::binnacle(bench, {"study", "drive.json", "--runs", "2", "--out", "one"}).status == 0);
  // In Slurm's place: its options are let go, and two ranks are started.
  fs::create_directory(bench.path("bin"));
  bench.write("bin/srun",
              "#!/bin/sh\nwhile case $1 in --*) true;; *) false;; esac; do shift; done\n"
              "exec mpirun --oversubscribe -n 2 \"$@\"\n");
  fs::permissions(bench.path("bin/srun"), fs::perms::owner_all);
  Start script = mpirun({});
  script.launcher = {"bash"};
  script.program = BINNACLE_TEST_PROJECT "/sdk/docs/study.sbatch";
  script.environment["PATH"] = bench.path("bin") + ":" + std::getenv("PATH");
  script.environment["BINNACLE"] = BINNACLE_TEST_COMMAND;
  const auto outcome = binnacle::test::binnacle(bench, {"drive.json", "ranks", "--runs", "2"}, script);
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  check_same_files(bench, "one", "ranks");
  CHECK(binnacle::test::binnacle(bench, {"drive.json"}, script).status == 2);
}

TEST_CASE("several processes that cannot find each other do not all do the same study") {
  const Workbench bench;
  write_drive(bench);
  fs::create_directory(bench.path("bin"));
  Start lone;
  lone.program = bench.path("bin/binnacle");  // where there is no module beside it
  fs::copy_file(BINNACLE_TEST_COMMAND, lone.program);
  fs::copy_file(BINNACLE_TEST_COMMAND "-study", lone.program + "-study");
  for (const auto& [size, rank] :
       {std::pair("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"), std::pair("PMI_SIZE", "PMI_RANK"),
        std::pair("SLURM_STEP_NUM_TASKS", "SLURM_PROCID")}) {
    lone.environment = {{size, "2"}, {rank, "0"}};
    const auto first = binnacle::test::binnacle(bench, {"study", "drive.json", "--out", "out"}, lone);
    CHECK(first.status == 2);
    CHECK(has(first.err, "error: 2 processes were started to carry out one study, but this binnacle has no MPI"));
    CHECK(has(first.err, "; start one, with --jobs N for its threads\n"));
    lone.environment = {{size, "2"}, {rank, "1"}};
    const auto second = binnacle::test::binnacle(bench, {"study", "drive.json", "--out", "out"}, lone);
    CHECK(second.err.empty());
    CHECK_FALSE(fs::exists(bench.path("out")));
  }
}

TEST_CASE("a command that was not started by mpirun has nothing of MPI in it") {
  for (const char* name : {BINNACLE_TEST_COMMAND, BINNACLE_TEST_COMMAND "-study"}) {
    std::ifstream file(name, std::ios::binary);
    const std::string program{std::istreambuf_iterator<char>(file), {}};
    CHECK_FALSE(program.empty());
    CHECK_FALSE(has(program, "libmpi.so"));
  }
}

TEST_CASE("memory does not grow with the number of runs") {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return;  // they keep what was freed
#endif
  const Workbench bench;
  write_drive(bench);
  const auto peak = [&](const char* runs) {
    const auto outcome =
        binnacle::test::binnacle(bench, {"study", "drive.json", "--jobs", "2", "--runs", runs, "--quiet"});
    REQUIRE(outcome.status == 0);
    return outcome.peak_memory / 1e6;
  };
  const double few = peak("5"), many = peak("60");  // of four variants
  INFO(few << " MB for 20 runs, " << many << " MB for 240");
  CHECK(many < few + 2);
}

}  // namespace mpi_test
