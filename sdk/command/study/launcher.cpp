// SPDX-License-Identifier: Apache-2.0
#include "launcher.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

#include <dlfcn.h>
#include <fmt/format.h>

#include "installation.hpp"
#include "output.hpp"
#include "sentinel.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

struct Launch {
  int size = 1;
  int rank = 0;
};

std::optional<int> number_in(const char* variable) {
  const char* const text = std::getenv(variable);
  return text && *text ? std::optional(std::atoi(text)) : std::nullopt;
}

/// What the launcher says in the environment: Open MPI's mpirun; MPICH's, Intel's, and srun's pmi2; srun.
Launch launch() {
  for (const auto& [size, rank] :
       {std::pair("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK"), std::pair("PMI_SIZE", "PMI_RANK"),
        std::pair("SLURM_STEP_NUM_TASKS", "SLURM_PROCID")})
    if (const auto count = number_in(size)) return {*count, number_in(rank).value_or(0)};
  return {};
}

fs::path module() { return prefix() / "lib/binnacle/mpi/binnacle_mpi.so"; }

/// One of them reports what is wrong with all.
[[noreturn]] void refuse(const Launch& launch, const std::string& why) {
  if (launch.rank > 0)
    std::exit(leave(ok));  // mpirun ends the others when one of them fails: rank 0 has to come to words
  throw UsageError(
      fmt::format("{} processes were started to carry out one study, but {}; start one, with --jobs N for "
                  "its threads",
                  launch.size, why));
}

study::JoinTeam find_join(const Launch& launch) {
  std::error_code error;
  if (!fs::exists(module(), error))
    refuse(launch, "this binnacle has no MPI, so each would do all runs (build it with libopenmpi-dev installed)");
  // Open MPI has plugins of its own, which look for its symbols among those of all.
  void* const library = dlopen(module().lexically_normal().c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (!library) refuse(launch, fmt::format("MPI cannot be loaded: {}", dlerror()));
  const auto join = reinterpret_cast<study::JoinTeam>(dlsym(library, "binnacle_join_team_2"));
  if (!join) refuse(launch, fmt::format("'{}' is of another version", module().lexically_normal().string()));
  return join;
}

}  // namespace

study::Timeouts team_timeouts() {
  study::Timeouts timeouts;
  const char* const text = std::getenv("BINNACLE_MPI_TIMEOUT");
  if (!text || !*text) return timeouts;
  char* end = nullptr;
  const double s = std::strtod(text, &end);
  if (*end || !(s >= 1 && s <= 86400))
    throw UsageError(fmt::format("BINNACLE_MPI_TIMEOUT takes 1 to 86400 seconds; found '{}'", text));
  timeouts.silence = std::chrono::milliseconds(static_cast<long>(1000 * s));
  timeouts.sign_of_life = std::min(timeouts.sign_of_life, timeouts.silence / 5);
  return timeouts;
}

std::unique_ptr<study::Team> join_team(const study::Timeouts& timeouts) {
  const Launch started = launch();
  if (started.size <= 1) return nullptr;
  std::unique_ptr<study::Team> team(
      find_join(started)(timeouts.silence, [](const char* message) { abandon(message); }));
  if (team->size() != started.size)
    refuse(started, "they do not find each other, because another MPI than that of this binnacle started them");
  return team;
}

}  // namespace binnacle::command
