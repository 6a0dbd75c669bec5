// SPDX-License-Identifier: Apache-2.0
// main() of the command and of its modules: one command line, its verbs, and their exit status.
#pragma once

#include <span>
#include <string_view>

namespace CLI {
class App;
}

namespace binnacle::command {

struct Verb;  // verbs.hpp

/// A verb that this program carries out; one of known_verbs().
struct OwnVerb {
  std::string_view name;
  Verb (*add)(CLI::App& command);
};

/// The status for main() to return. `module`: this program's name in known_verbs(), "" of the command itself. The
/// command hands the verbs that are not its own over to their modules; a module takes nothing but its own.
int command_main(int argc, char** argv, std::string_view module, std::span<const OwnVerb> own);

/// Verbs of the command itself.
Verb run_verb(CLI::App& command);
Verb check_verb(CLI::App& command);
Verb version_verb(CLI::App& command);

/// Verbs of binnacle-study; its check knows "study", "covariance" and "tune" too.
Verb study_verb(CLI::App& command);
Verb covariance_verb(CLI::App& command);
Verb tune_verb(CLI::App& command);
Verb observe_verb(CLI::App& command);
Verb allan_verb(CLI::App& command);
Verb whole_check_verb(CLI::App& command);

/// Verbs of binnacle-inspect.
Verb inspect_verb(CLI::App& command);

/// Verbs of binnacle-describe.
Verb explain_verb(CLI::App& command);
Verb list_verb(CLI::App& command);
Verb describe_verb(CLI::App& command);
Verb create_verb(CLI::App& command);
Verb schema_verb(CLI::App& command);
Verb graph_verb(CLI::App& command);
Verb new_verb(CLI::App& command);

/// Verbs of binnacle-report.
Verb report_verb(CLI::App& command);
Verb export_verb(CLI::App& command);
Verb verdict_verb(CLI::App& command);

}  // namespace binnacle::command
