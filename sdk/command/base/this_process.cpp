// SPDX-License-Identifier: Apache-2.0
#include "this_process.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <random>

#include <fmt/format.h>
#include <unistd.h>

namespace binnacle::command {

namespace {

std::string host() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) return "?";
  return name.data();
}

}  // namespace

std::string name_of_this_process() { return fmt::format("process {} on {}", ::getpid(), host()); }

std::string unique_suffix() {
  std::string name = host().substr(0, 64);  // a file's name has an end
  std::ranges::replace_if(
      name, [](unsigned char c) { return !std::isalnum(c); }, '-');
  std::random_device random;
  const std::uint64_t number = std::uint64_t{random()} << 32 | random();
  return fmt::format("{}-{}-{:016x}", name, ::getpid(), number);
}

}  // namespace binnacle::command
