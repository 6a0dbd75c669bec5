// SPDX-License-Identifier: Apache-2.0
// testing::bind() for these tests, which write parameters as braces of nlohmann::json.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "binnacle/bind.hpp"
#include "support/navigation_kinds.hpp"

namespace binnacle::test {

using testing::AdditiveKind;
using testing::AttitudeKind;
using testing::KindBlock;
using testing::PositionKind;
using Ports = std::map<std::string, const StateBlock*>;

/// What testing::Setup has of it, in this order.
struct Setup {
  nlohmann::json parameters = nlohmann::json::object();
  Ports ports;
  std::vector<std::string> without;
  int samples_per_step = 1;
  std::vector<NamedUnit> covariance = {};
  std::vector<std::string> frozen = {};

  operator testing::Setup() const {
    return {.parameters = parameters,
            .ports = ports,
            .without = without,
            .samples_per_step = samples_per_step,
            .covariance = covariance,
            .frozen = frozen};
  }
};

inline bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

template <class Component>
std::unique_ptr<Component> bind(const Setup& setup = {}) {
  return testing::bind<Component>(setup);
}

}  // namespace binnacle::test
