// SPDX-License-Identifier: Apache-2.0
// What is read of a u-blox receiver: messages, channels, fields.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "binnacle/spec.hpp"
#include "payload.hpp"

namespace binnacle::ublox {

enum class Kind { pvt, posllh, velned, hpposllh, relposned, ins, imu, imu_raw, wheels, obs, subframe };
inline constexpr int kind_count = 11;

/// Message class << 8 | id.
enum Type : int {
  nav_posllh = 0x0102,
  nav_status = 0x0103,
  nav_pvt = 0x0107,
  nav_velned = 0x0112,
  nav_hpposllh = 0x0114,
  nav_relposned = 0x013C,
  rxm_sfrbx = 0x0213,
  rxm_rawx = 0x0215,
  esf_meas = 0x1002,
  esf_raw = 0x1003,
  esf_ins = 0x1015,
};

/// "NAV-PVT", and as the class and id of one that is not known.
std::string message_name(int type);
/// Of the messages that are read; NAV-STATUS, which has no channel, is not among them.
std::vector<std::string> message_names();
/// −1: none of them.
int message_type(std::string_view name);

/// A kind whose samples are a row of numbers.
struct ValueKind {
  Kind kind;
  int type;             // of the message
  const char* channel;  // "" : the source's own name
  std::vector<FieldSpec> fields;
};
std::vector<ValueKind> value_kinds();

/// What a navigation message (NAV-…, ESF-INS) gives, in the order of its kind's fields.
struct Reading {
  std::vector<double> values;
  const char* refusal = nullptr;  // why it is left out; null: it is not
};
/// Nothing: its length or version is not known.
std::optional<Reading> read_solution(Kind kind, const Payload& payload);

}  // namespace binnacle::ublox
