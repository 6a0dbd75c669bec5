// SPDX-License-Identifier: Apache-2.0
// What the plugin `stationary_detector` brings.
#include "binnacle/plugin.hpp"

#include "detection_score.hpp"
#include "stance_detector.hpp"
#include "stationary_detector.hpp"

BINNACLE_TYPES("detection_score stance_detector stationary_detector");

BINNACLE_PLUGIN("stationary_detector", "1.0.0", registry) {
  using namespace binnacle::stationary_detector;
  registry.add<StationaryDetector>();
  registry.add<DetectionScore>();
  registry.add<StanceDetector>();
}
