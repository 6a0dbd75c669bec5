// SPDX-License-Identifier: Apache-2.0
// A filter inside a program: samples are pushed, the estimate and its covariance are read.
#include <cmath>
#include <cstdio>

#include <binnacle/session.hpp>

int main(int, char** arguments) try {
  binnacle::Session filter(binnacle::Composition::load(arguments[1]));

  // Names are looked up once, before the loop; a wrong one throws with what was meant.
  const auto altimeter = filter.channel("altimeter");
  const auto walk = filter.filter("walk");
  const auto height = filter.block("walk/height");
  const auto seen = filter.measurement("walk/seen");

  for (int second = 0; second <= 10; ++second) {
    const double z[] = {second == 5 ? 50.0 : 2.0};  // m; the sixth is a fault, which the gate keeps out
    filter.push(altimeter, binnacle::no_time, binnacle::nanoseconds(second), z);
  }
  if (!filter.healthy(walk)) {
    std::fprintf(stderr, "%s\n", filter.diagnosis(walk).c_str());
    return 1;
  }

  double estimate[1];
  filter.read(height, estimate);
  const double variance = filter.covariance(height)(0, 0);  // m²
  const auto counts = filter.counts(seen);
  std::printf("height %.2f m, sigma %.3f m, %d of %d accepted\n", estimate[0], std::sqrt(variance),
              static_cast<int>(counts.by_outcome[static_cast<int>(binnacle::Outcome::accepted)]),
              static_cast<int>(counts.offered));
  return 0;
} catch (const binnacle::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());  // every error of the config, a line each
  return error.exit_status();
}
