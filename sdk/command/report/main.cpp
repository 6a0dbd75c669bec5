// SPDX-License-Identifier: Apache-2.0
// binnacle-report: verbs for results that are there.
#include "command_main.hpp"

int main(int argc, char** argv) {
  using namespace binnacle::command;
  constexpr OwnVerb verbs[] = {{"report", report_verb}, {"export", export_verb}, {"verdict", verdict_verb}};
  return command_main(argc, argv, "binnacle-report", verbs);
}
