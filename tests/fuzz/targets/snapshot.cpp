// SPDX-License-Identifier: Apache-2.0
// A snapshot that was changed and sealed again, as whoever means harm would: it is refused, or the session goes on.
#include <cstring>
#include <string>

#include "../composing.hpp"
#include "../edits.hpp"
#include "binnacle/session.hpp"
#include "snapshot_attack.hpp"

namespace binnacle::fuzz {

namespace {

const char* const config = R"({"binnacle": 1,
  "sources": {"z": {"type": "pushed", "fields": {"z0": {"unit": "m"}}}},
  "filters": {"f": {
    "history": "3 s",
    "blocks": {"x": {"type": "vector", "size": 1, "unit": "m", "init": 1, "sigma": 2},
               "b": {"type": "vector", "size": 1, "unit": "m", "init": 0, "sigma": 1}},
    "process": {"walk": {"type": "random_walk", "blocks": {"x": "x"}, "q": 0.4},
                "drift": {"type": "gauss_markov", "blocks": {"x": "b"}, "tau": "100 s", "sigma": "1 m"}},
    "measurements": {"fix": {"type": "linear_measurement", "channel": "z", "blocks": {"x": "x"}, "sigma": [0.7], "gate": 0.999,
                             "noise": {"type": "huber", "by": "row"}}}}}})";

/// What its forged past may make of it is an error with words, if anything.
void go_on(Session& session, int from, int until) {
  const auto z = session.channel("z");
  try {
    for (int k = from; k < until; ++k) {
      const double seen[] = {k % 7 == 3 ? 60.0 : 1 + 0.1 * k};
      session.push(z, no_time, nanoseconds(k), seen);
    }
  } catch (const Error&) {
  }
}

}  // namespace

void try_bytes(std::string_view bytes) {
  static Session session = [] {
    const auto composition = composed(config);
    if (!composition) throw std::logic_error("the target's own config is refused: are its plugins built?");
    Session fresh(composition);
    go_on(fresh, 0, 20);
    return fresh;
  }();
  static const auto good = snapshot_attack::snapshot_of(session);
  const std::string payload(reinterpret_cast<const char*>(good.data()) + sizeof(snapshot_attack::Head),
                            good.size() - sizeof(snapshot_attack::Head));
  const std::string changed = edited(payload, bytes);
  snapshot_attack::Bytes snapshot(good.begin(), good.begin() + sizeof(snapshot_attack::Head));
  snapshot.resize(snapshot.size() + changed.size());
  std::memcpy(snapshot.data() + sizeof(snapshot_attack::Head), changed.data(), changed.size());
  snapshot_attack::reseal(snapshot);
  if (!snapshot_attack::is_taken(session, snapshot)) return;
  go_on(session, 20, 30);
  session.verdict({0});
  session.doubts({0});
  session.restore(good);
}

}  // namespace binnacle::fuzz
