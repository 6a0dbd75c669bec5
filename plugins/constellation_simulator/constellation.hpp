// SPDX-License-Identifier: Apache-2.0
// Which satellites there are: a regular constellation, or those of an almanac.
#pragma once

#include <vector>

#include "binnacle/binding.hpp"
#include "binnacle/spec.hpp"
#include "gnss/orbit.hpp"

namespace binnacle::constellation_simulator {

std::vector<ParameterSpec> constellation_parameters();

/// Walker's i: T/P/F: T satellites on circular orbits in P planes whose nodes are 360°/P apart; neighbours in a plane are
/// 360° P/T apart, and a satellite leads its neighbour in the next plane by −360° F/T. Numbers run through a plane first.
/// J. G. Walker, "Continuous whole-earth coverage by circular-orbit satellite patterns", RAE TR 77044 (1977).
/// Or, with 'almanac', what a YUMA file says. Throws ComponentError.
std::vector<gnss::Ephemeris> read_constellation(const Binding& binding);

/// The satellites of a YUMA almanac that call themselves healthy. Throws ComponentError in the file.
std::vector<gnss::Ephemeris> read_almanac(const std::string& path);

}  // namespace binnacle::constellation_simulator
