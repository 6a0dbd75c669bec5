// SPDX-License-Identifier: Apache-2.0
// A serial device or a pseudo-terminal.
#pragma once

#include "address/address.hpp"
#include "address/descriptor.hpp"

namespace binnacle::address {

/// Whether this system's serial devices know the rate.
bool is_baud(int baud);

/// Opened raw, 8 data bits, no parity, one stop bit, no flow control; does not block. Invalid where it cannot be: errno says
/// why.
Descriptor open_serial(const Address& address);

}  // namespace binnacle::address
