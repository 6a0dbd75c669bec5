// SPDX-License-Identifier: Apache-2.0
// check of every config, with the sections that are not a run's.
#include "check.hpp"
#include "warnings.hpp"

namespace binnacle::command {

Verb whole_check_verb(CLI::App& command) { return add_check(command, warnings_of); }

}  // namespace binnacle::command
