// SPDX-License-Identifier: Apache-2.0
// A simulator for tests: with parameters from JSON as the kernel checks them, sample by sample.
#pragma once

#include "binnacle/bind.hpp"
#include "binnacle/testing.hpp"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "catch.hpp"
#include "strapdown/rotation.hpp"

namespace binnacle::simulation {

using Json = nlohmann::ordered_json;

template <class Simulator>
ParameterValue checked(const Json& config) {
  return testing::read_parameters(Simulator::spec(), {config});
}

struct Emitted {
  int channel;
  Time t, t0;
  std::vector<double> fields, covariance;

  bool operator==(const Emitted& other) const = default;
  Eigen::Vector3d triple(std::size_t first) const { return {fields[first], fields[first + 1], fields[first + 2]}; }
  Eigen::Vector4d attitude(std::size_t first) const { return strapdown::quaternion_from_euler(triple(first)); }
};

template <class Simulator>
class Simulation {
 public:
  explicit Simulation(const Json& config, std::uint64_t seed = 1) {
    source_ = testing::bind<Simulator>({config});
    struct Quiet final : Reporter {
      void warn(const std::string&, const std::string&, int, const std::string&) override {}
    } quiet;
    source_->open(quiet);
    restart(seed);
  }

  void restart(std::uint64_t seed) { memory_ = testing::SourceCaller(*source_).fresh_memory(seed); }

  std::optional<Emitted> next() {
    const auto next = testing::SourceCaller(*source_).next(memory_.data());
    REQUIRE(next.damage.empty());
    if (next.status == SourceStatus::end) return std::nullopt;
    return Emitted{next.sample.channel, next.sample.t, next.sample.t0, next.sample.fields, next.sample.covariance};
  }

  std::vector<Emitted> rest() {
    std::vector<Emitted> all;
    while (auto sample = next()) all.push_back(std::move(*sample));
    return all;
  }

  std::vector<Emitted> of(int channel) {
    std::vector<Emitted> chosen;
    while (auto sample = next())
      if (sample->channel == channel) chosen.push_back(std::move(*sample));
    return chosen;
  }

  std::vector<std::byte>& memory() { return memory_; }
  const std::vector<ChannelDeclaration>& channels() const { return source_->declaration().channels; }

 private:
  std::shared_ptr<Simulator> source_;
  std::vector<std::byte> memory_;
};

}  // namespace binnacle::simulation
