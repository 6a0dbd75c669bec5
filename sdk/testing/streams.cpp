// SPDX-License-Identifier: Apache-2.0
// Calls of sources and transforms.
#include <algorithm>
#include <array>

#include "guarded.hpp"

namespace binnacle::testing {

namespace {

/// The writers of a component's channels, on memory between canaries.
class Writers {
 public:
  Writers(const std::vector<ChannelDeclaration>& channels, double fill) {
    for (const auto& channel : channels) {
      SampleWriter writer;
      writer.field_count = channel.count(false);
      writer.row_width = channel.count(true);
      writer.max_rows = channel.max_rows;
      writer.covariance_dof = static_cast<int>(channel.covariance.size());
      const auto storage = [&](std::vector<Guarded>& all, int count) {
        return all.emplace_back(as_size(count), fill).data();
      };
      writer.fields = storage(fields_, writer.field_count);
      writer.row_fields = storage(rows_, writer.row_width * writer.max_rows);
      writer.covariance = storage(covariance_, writer.covariance_dof * writer.covariance_dof);
      writers_.push_back(writer);
    }
  }
  bool has(int channel) const { return channel >= 0 && channel < static_cast<int>(writers_.size()); }
  SampleWriter* data() { return writers_.data(); }
  SampleWriter& at(int channel) { return writers_.at(as_size(channel)); }
  std::string damage() const {
    for (const auto* parts : {&fields_, &rows_, &covariance_})
      for (const Guarded& part : *parts)
        if (!part.is_intact()) return "a sample: written beyond its end";
    return {};
  }
  Emitted emitted(int channel) const {
    const SampleWriter& writer = writers_[as_size(channel)];
    Emitted sample{channel, writer.t, writer.t0, writer.rows, {}, {}, {}};
    sample.fields.assign(writer.fields, writer.fields + writer.field_count);
    const int rows = std::clamp(writer.rows, 0, writer.max_rows);
    sample.row_fields.assign(writer.row_fields, writer.row_fields + rows * writer.row_width);
    if (writer.has_covariance)
      sample.covariance.assign(writer.covariance, writer.covariance + writer.covariance_dof * writer.covariance_dof);
    return sample;
  }

 private:
  std::vector<Guarded> fields_, rows_, covariance_;
  std::vector<SampleWriter> writers_;
};

/// Keeps no more than which channels were emitted on, so that it allocates nothing while the plugin is at work.
class Collector final : public Emitter {
 public:
  explicit Collector(Writers& writers) : writers_(writers) {}
  SampleWriter& on(OutputChannel channel) override { return writers_.at(channel.index()); }
  void emit(OutputChannel channel) override {
    if (!writers_.has(channel.index()))
      damage_ = "it emits on a channel that it has not";
    else if (count_ < channels_.size())
      channels_[count_++] = channel.index();
  }
  void emit_again(OutputChannel channel) override { emit(channel); }
  TransformCaller::Made made() const {
    TransformCaller::Made all;
    for (std::size_t i = 0; i < count_; ++i) all.samples.push_back(writers_.emitted(channels_[i]));
    all.damage = damage_;
    return all;
  }

 private:
  Writers& writers_;
  std::array<int, 64> channels_{};
  std::size_t count_ = 0;
  const char* damage_ = "";
};

template <class Stream>
std::vector<std::byte> fresh_memory_of(const Stream& stream, std::uint64_t seed) {
  std::vector<std::byte> memory(stream.declaration().memory_bytes);
  called("start", [&] { return stream.start(seed, memory.data()), 0; });
  return memory;
}

}  // namespace

SampleView Emitted::view() const {
  return {t, t0, rows, fields.data(), row_fields.data(), covariance.empty() ? nullptr : covariance.data(), true};
}

std::vector<std::byte> SourceCaller::fresh_memory(std::uint64_t seed) const { return fresh_memory_of(*source_, seed); }

SourceCaller::Next SourceCaller::next(MemoryView memory, double fill) const {
  Writers writers(source_->declaration().channels, fill);
  SourceOutput out(writers.data());
  Next answer;
  answer.status = called("next", [&] { return source_->next(memory, out); });
  answer.damage = writers.damage();
  if (answer.status != SourceStatus::sample) return answer;
  if (writers.has(out.channel()))
    answer.sample = writers.emitted(out.channel());
  else
    answer.damage = "there is no channel " + std::to_string(out.channel());
  return answer;
}

std::vector<std::byte> TransformCaller::fresh_memory(std::uint64_t seed) const {
  return fresh_memory_of(*transform_, seed);
}

TransformCaller::Made TransformCaller::on(std::size_t input, const SampleView& sample, MemoryView memory,
                                          double fill) const {
  Writers writers(transform_->declaration().channels, fill);
  Collector collector(writers);
  Inputs inputs;
  const ChannelPort& port = spec_->inputs.at(input);
  const TransformInput in{Input(static_cast<int>(input), true), guarded_sample(sample, port.fields, port.name, inputs),
                          memory};
  called("on", [&] { return transform_->on(in, collector), 0; });
  Made made = collector.made();
  if (made.damage.empty()) made.damage = inputs.damage("on");
  if (const std::string beyond = writers.damage(); !beyond.empty()) made.damage = beyond;
  return made;
}

}  // namespace binnacle::testing
