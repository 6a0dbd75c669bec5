// SPDX-License-Identifier: Apache-2.0
// Where mpirun or srun started several of this command: they find each other.
#pragma once

#include <memory>

#include "study/coordinator.hpp"
#include "study/team.hpp"

namespace binnacle::command {

/// Of BINNACLE_MPI_TIMEOUT, in seconds, where it is set. Throws UsageError where that is no such number.
study::Timeouts team_timeouts();

/// Null where this is the only process: then nothing of MPI is touched. Throws UsageError where several were started that
/// cannot find each other, which would all do the same.
std::unique_ptr<study::Team> join_team(const study::Timeouts& timeouts);

}  // namespace binnacle::command
