// SPDX-License-Identifier: Apache-2.0
// The plugin battery: a cell's state of charge from its current and its terminal voltage.
#include "cell_simulator.hpp"
#include "terminal_voltage.hpp"
#include "thevenin.hpp"

BINNACLE_PLUGIN("battery", "1.0.0", registry) {
  registry.add<Thevenin>();
  registry.add<TerminalVoltage>();
  registry.add<CellSimulator>();
}
