// SPDX-License-Identifier: Apache-2.0
// binnacle: what a run needs; the other verbs are in the modules beside it.
#include "command_main.hpp"

int main(int argc, char** argv) {
  using namespace binnacle::command;
  constexpr OwnVerb verbs[] = {{"run", run_verb}, {"check", check_verb}, {"version", version_verb}};
  return command_main(argc, argv, "", verbs);
}
