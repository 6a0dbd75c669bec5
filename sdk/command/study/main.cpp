// SPDX-License-Identifier: Apache-2.0
// binnacle-study: verbs that run a config many times, or analyse what it would do.
#include "command_main.hpp"

int main(int argc, char** argv) {
  using namespace binnacle::command;
  constexpr OwnVerb verbs[] = {{"study", study_verb},     {"covariance", covariance_verb}, {"tune", tune_verb},
                               {"observe", observe_verb}, {"allan", allan_verb},           {"check", whole_check_verb}};
  return command_main(argc, argv, "binnacle-study", verbs);
}
