// SPDX-License-Identifier: Apache-2.0
// A copy of blocks as they were at an instant.
#include "clone.hpp"

#include <algorithm>
#include <cstdint>
#include <string>

#include "binnacle/time.hpp"
#include "elapsed.hpp"

namespace binnacle::clone {

namespace {

constexpr std::array<std::array<const char*, 2>, 3> port_names = {
    {{"of", "copy"}, {"of_2", "copy_2"}, {"of_3", "copy_3"}}};

}  // namespace

ComponentSpec Clone::spec() {
  ComponentSpec spec;
  spec.type = "clone";
  spec.summary = "Keeps a copy of blocks at an instant, with all correlations: stochastic cloning.";
  spec.source = "Roumeliotis and Burdick, Stochastic cloning, IEEE ICRA 2002, section III";
  spec.parameters = {
      parameter::time("every").above(0).about("shortest time between copies: the first step that begins later makes "
                                              "one; default: copies only at samples on 'at'")};
  spec.ports = {reads("of", "*").about("block to be copied: a block of any kind, or a derived block"),
                advances("copy", "*").about("the copy: a block of the same kind"),
                reads("of_2", "*").optional().about("second or third block to be copied, at the same instants"),
                {"copy_2", "*", PortAccess::advances, true, "the copy of of_2"},
                reads("of_3", "*").optional().about("second or third block to be copied, at the same instants"),
                {"copy_3", "*", PortAccess::advances, true, "the copy of of_3"},
                {"age", "vector:1:s", PortAccess::advances, true, "time since the copy was made"}};
  spec.inputs = {input("at", {}).optional().about(
      "a copy is made at the time of each sample; usually the channel of the measurement that uses the copy")};
  spec.example = R"json({"blocks": {"of": "position", "copy": "position_then", "of_2": "attitude",
    "copy_2": "attitude_then", "age": "age"}, "inputs": {"at": "camera"}})json";
  spec.surroundings = R"json({"blocks": {
    "position": {"type": "navigation/position", "init": {"lat": "37.4 deg", "lon": "126.9 deg", "height": "60 m"}, "sigma": 5},
    "attitude": {"type": "navigation/attitude", "init": {"roll": 0.02, "pitch": -0.03, "yaw": -0.6}, "sigma": 0.02},
    "position_then": {"type": "navigation/position", "init": {"lat": "37.4 deg", "lon": "126.9 deg", "height": "60 m"}, "sigma": 5},
    "attitude_then": {"type": "navigation/attitude", "init": {"roll": 0.02, "pitch": -0.03, "yaw": -0.6}, "sigma": 0.02},
    "age": {"type": "vector", "size": 1, "unit": "s", "sigma": 0.1}}})json";
  return spec;
}

Clone::Clone(const Binding& binding) : age_(binding.port("age")), at_(binding.input("at")) {
  for (const auto& [of_name, copy_name] : port_names) {
    Pair pair{binding.port(of_name), binding.port(copy_name), {}, {}};
    if (!pair.of.is_bound() && !pair.copy.is_bound()) continue;
    if (!pair.of.is_bound() || !pair.copy.is_bound())
      throw ComponentError(std::string("'") + of_name + "' and '" + copy_name + "' need each other", "/blocks");
    const std::string &kind = binding.block(of_name).kind, &kind_of_copy = binding.block(copy_name).kind;
    if (kind != kind_of_copy)
      throw ComponentError("a copy has the kind of what it copies: '" + std::string(of_name) + "' is of the kind '" +
                               kind + "', '" + copy_name + "' of the kind '" + kind_of_copy + "'",
                           std::string("/blocks/") + copy_name);
    pair.by_of = declaration_.couples(pair.copy, pair.of, Structure::diagonal);
    pair.by_copy = declaration_.couples(pair.copy, pair.copy, Structure::diagonal);
    pairs_.push_back(pair);
  }
  age_by_age_ = declaration_.couples(age_, age_, Structure::diagonal);
  if (binding.parameters().has("every")) every_ = binding.parameters().time("every");
  if (every_ == 0 && !at_.is_bound())
    throw ComponentError("nothing specifies when to copy: name a channel, \"inputs\": {\"at\": …}, or 'every'");
  memory_ = declaration_.keeps<Memory>();
}

/// May be asked twice in one step and answers the same: who propagates sigma points asks for each.
bool Clone::is_due(const ProcessInput& in, Memory& memory) const {
  const Time now = in.step.t0;
  if (memory.copied == now) return true;
  bool is_due = memory.copied == no_time || (every_ > 0 && elapsed(memory.copied, now) >= every_);
  const SampleView newest = at_.is_bound() ? in.auxiliary[at_] : SampleView{};
  const std::size_t room = memory.waiting.size();
  std::size_t count = std::min(static_cast<std::size_t>(std::max<std::int64_t>(memory.count, 0)), room);
  if (newest.available && newest.t != memory.newest) {
    memory.newest = newest.t;
    if (count < room)
      memory.waiting[count++] = newest.t;
    else
      in.notes.leave("more than 64 samples of 'at' are ahead of the filter; no copy is made of some");
  }
  if (newest.available && newest.t0 == now) is_due = true;
  const auto end = memory.waiting.begin() + static_cast<std::ptrdiff_t>(count);
  const auto ahead = std::partition(memory.waiting.begin(), end, [&](Time t) { return t > now; });
  for (auto past = ahead; past != end; ++past) is_due = is_due || *past > memory.copied;
  memory.count = ahead - memory.waiting.begin();
  if (is_due) memory.copied = now;
  return is_due;
}

Result Clone::propagate(const ProcessInput& in, ProcessOutput& out) const {
  Memory& memory = in.memory[memory_];
  const bool moves = in.step.t1 > in.step.t0;
  const bool copies = moves && is_due(in, memory);
  for (const Pair& pair : pairs_) {
    out.x[pair.copy].as() = in.x[copies ? pair.of : pair.copy].as();
    if (const BlockView Phi = out.phi[pair.by_of]) Phi.diagonal().setConstant(copies ? 1 : 0);
    if (const BlockView Phi = out.phi[pair.by_copy]) Phi.diagonal().setConstant(copies ? 0 : 1);
  }
  if (!age_.is_bound()) return Result::ok();
  out.x[age_][0] = moves ? seconds(elapsed(memory.copied, in.step.t1)) : in.x[age_][0];
  if (const BlockView Phi = out.phi[age_by_age_]) Phi.diagonal()[0] = moves ? 0 : 1;
  return Result::ok();
}

}  // namespace binnacle::clone
