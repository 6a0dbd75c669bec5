// SPDX-License-Identifier: Apache-2.0
// binnacle-inspect: data before a filter uses them.
#include "command_main.hpp"

int main(int argc, char** argv) {
  using namespace binnacle::command;
  constexpr OwnVerb verbs[] = {{"inspect", inspect_verb}};
  return command_main(argc, argv, "binnacle-inspect", verbs);
}
