// SPDX-License-Identifier: Apache-2.0
// binnacle-describe: verbs that say what components and compositions are, and start new ones.
#include "command_main.hpp"

int main(int argc, char** argv) {
  using namespace binnacle::command;
  constexpr OwnVerb verbs[] = {{"explain", explain_verb}, {"list", list_verb},     {"describe", describe_verb},
                               {"create", create_verb},   {"schema", schema_verb}, {"graph", graph_verb},
                               {"new", new_verb}};
  return command_main(argc, argv, "binnacle-describe", verbs);
}
