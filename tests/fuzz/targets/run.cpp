// SPDX-License-Identifier: Apache-2.0
// A config, composed and run, until it has no more data or for so many instants.
#include "score/run.hpp"
#include "../composing.hpp"

namespace binnacle::fuzz {

namespace {

constexpr int most_instants = 200;

struct Enough {};

class Stopper final : public score::RunObserver {
 public:
  void after_instant() override {
    if (++instants_ > most_instants) throw Enough{};
  }

 private:
  int instants_ = 0;
};

}  // namespace

void try_bytes(std::string_view bytes) {
  const auto composition = composed(bytes);
  if (!composition) return;
  Stopper stopper;
  score::RunOptions options;
  options.observer = &stopper;
  options.feeds_sinks = false;
  try {
    score::run(composition, options);
  } catch (const Enough&) {
  } catch (const Error&) {
  }
}

}  // namespace binnacle::fuzz
