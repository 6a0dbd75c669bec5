// SPDX-License-Identifier: Apache-2.0
#include "run/checkpoint.hpp"

#include <array>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "run/checksum.hpp"

namespace binnacle::internal::runtime {

namespace {

/// What bytes of a state mean the same on.
constexpr char machine[16] =
#if defined(__x86_64__)
    "x86-64"
#elif defined(__aarch64__)
    "aarch64"
#else
    "?"
#endif
    ;

[[noreturn]] void refuse(const std::string& why) {
  throw ConfigError(Diagnostic{Severity::error, "B084", {}, "", "the run cannot be resumed: " + why});
}

std::uint64_t checksum_of_file(const std::string& path, std::uint64_t start) {
  std::ifstream file(path, std::ios::binary);
  std::array<char, 1 << 16> block;
  std::uint64_t sum = checksum(std::as_bytes(std::span(path)), start);
  while (file.read(block.data(), block.size()) || file.gcount() > 0)
    sum = checksum(std::as_bytes(std::span(block).first(static_cast<std::size_t>(file.gcount()))), sum);
  return sum;
}

/// Of the files that sources read again; what is live is new each time.
std::uint64_t checksum_of_data(const CompositionPlan& plan) {
  std::uint64_t sum = 0;
  for (const auto& source : plan.sources)
    if (!source.object->declaration().live)
      for (const auto& file : source.files) sum = checksum_of_file(file, sum);
  return sum;
}

}  // namespace

struct Checkpointing::Head {
  char magic[8] = {'b', 'i', 'n', 'c', 'k', 'p', 't', '2'};
  char kind[16] = {};
  std::uint64_t composition = 0, data = 0, seed = 0, size = 0;
  std::int64_t run = 0, shown = 0;
  std::uint64_t checksum = 0;  // of all, as if it were zero
};

Checkpointing::Checkpointing(Runtime& runtime, std::uint64_t composition, const RunOptions& options,
                             std::function<void(StateBytes& bytes)> exchange)
    : runtime_(runtime), composition_(composition), options_(options), exchange_(std::move(exchange)) {
  if (options.checkpoints.keeper || !options.checkpoints.from.empty()) data_ = checksum_of_data(runtime.plan());
}

Checkpointing::Head Checkpointing::head(std::uint64_t size) const {
  Head head;
  std::memcpy(head.kind, machine, sizeof machine);
  head.composition = composition_;
  head.data = data_;
  head.seed = options_.seed;
  head.run = options_.run;
  head.shown = static_cast<std::int64_t>(options_.estimates);
  head.size = size;
  return head;
}

void Checkpointing::begin() {
  if (!options_.checkpoints.from.empty()) resume();
  if (options_.checkpoints.keeper) keep();
}

void Checkpointing::exchange(StateBytes& bytes) {
  runtime_.exchange(bytes);
  // Observers forget what was before; what they kept comes next.
  if (bytes.is_reading() && bytes.holds()) runtime_.restored();
  runtime_.exchange_account(bytes);
  exchange_(bytes);
}

void Checkpointing::keep() {
  const Time t = runtime_.time(), every = options_.checkpoints.every;
  if (t != no_time && next_ == no_time) next_ = t;
  if (t != no_time && next_ <= t) next_ += ((t - next_) / every + 1) * every;
  StateBytes count;
  exchange(count);
  bytes_.resize(sizeof(Head) + count.size());
  const auto payload = std::span(bytes_).subspan(sizeof(Head));
  auto bytes = StateBytes::write(payload);
  exchange(bytes);
  Head head = this->head(payload.size());
  head.checksum = checksum_of(head, payload);
  std::memcpy(bytes_.data(), &head, sizeof head);
  options_.checkpoints.keeper->keep(bytes_);
}

void Checkpointing::resume() {
  const auto from = options_.checkpoints.from;
  Head found;
  if (from.size() < sizeof found)
    refuse("the checkpoint is incomplete: it has only " + std::to_string(from.size()) + " bytes");
  std::memcpy(&found, from.data(), sizeof found);
  const auto payload = from.subspan(sizeof found);
  const Head own = head(payload.size());
  if (std::memcmp(found.magic, own.magic, sizeof own.magic) != 0) refuse("this is not a checkpoint");
  if (std::memcmp(found.kind, own.kind, sizeof own.kind) != 0)
    refuse("the checkpoint was made on another kind of machine, " +
           std::string(found.kind, strnlen(found.kind, sizeof found.kind)) + ", and this is " + own.kind);
  if (found.size != own.size || checksum_of(found, payload) != found.checksum) refuse("the checkpoint is damaged");
  if (found.composition != own.composition)
    refuse("the checkpoint belongs to another config, other plugins or another version of this program");
  if (found.seed != own.seed || found.run != own.run)
    refuse("the checkpoint belongs to seed " + std::to_string(found.seed) + ", run " + std::to_string(found.run) +
           ", and this is seed " + std::to_string(own.seed) + ", run " + std::to_string(own.run));
  if (found.data != own.data) refuse("the data files are not those that the checkpoint was made with");
  if (found.shown != own.shown) refuse("the checkpoint belongs to other options");
  restore(payload);
}

/// A live source is as it has just been started: its cursor is nowhere that one could go back to.
void Checkpointing::restore(std::span<const std::byte> from) {
  std::vector<std::pair<std::byte*, std::vector<std::byte>>> live;
  for (const auto& source : runtime_.plan().sources) {
    if (!source.object->declaration().live) continue;
    std::byte* const memory = source.memory.in(runtime_.arena());
    live.emplace_back(memory, std::vector<std::byte>(memory, memory + source.memory.count));
  }
  auto bytes = StateBytes::read(from);
  exchange(bytes);
  if (!bytes.holds()) refuse("its content is damaged, or belongs to other options");
  if (bytes.size() != from.size()) refuse("the checkpoint belongs to other options");
  for (const auto& [memory, as_started] : live) std::ranges::copy(as_started, memory);
}

}  // namespace binnacle::internal::runtime
