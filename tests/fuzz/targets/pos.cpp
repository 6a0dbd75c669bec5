// SPDX-License-Identifier: Apache-2.0
#include "../reader.hpp"
#include "rtklib/pos_source.hpp"

void binnacle::fuzz::try_bytes(std::string_view bytes) { read_file<rtklib::PosSource>("rover.pos", bytes, {}); }
