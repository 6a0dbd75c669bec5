// SPDX-License-Identifier: Apache-2.0
#include "address/serial.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include <fcntl.h>
#include <termios.h>

namespace binnacle::address {

namespace {

constexpr auto rates = std::to_array<std::pair<int, speed_t>>({{1200, B1200},
                                                               {2400, B2400},
                                                               {4800, B4800},
                                                               {9600, B9600},
                                                               {19200, B19200},
                                                               {38400, B38400},
                                                               {57600, B57600},
                                                               {115200, B115200},
                                                               {230400, B230400},
                                                               {460800, B460800},
                                                               {500000, B500000},
                                                               {576000, B576000},
                                                               {921600, B921600},
                                                               {1000000, B1000000},
                                                               {1500000, B1500000},
                                                               {2000000, B2000000},
                                                               {3000000, B3000000},
                                                               {4000000, B4000000}});

const auto* find(int baud) {
  return std::find_if(rates.begin(), rates.end(), [&](const auto& rate) { return rate.first == baud; });
}

}  // namespace

bool is_baud(int baud) { return find(baud) != rates.end(); }

Descriptor open_serial(const Address& address) {
  Descriptor device(::open(address.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  termios settings{};
  if (!device || ::tcgetattr(device.get(), &settings) != 0) return {};
  ::cfmakeraw(&settings);
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 1;  // with 0 a read of nothing would look like the end
  settings.c_cc[VTIME] = 0;
  ::cfsetspeed(&settings, find(address.baud)->second);
  if (::tcsetattr(device.get(), TCSANOW, &settings) != 0) return {};
  return device;
}

}  // namespace binnacle::address
