// SPDX-License-Identifier: Apache-2.0
// The samples of a file, in memory as far as they have room there, and else read again by blocks.
#include "csv_table.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "block_store.hpp"
#include "cells.hpp"
#include "decimation.hpp"
#include "gaps.hpp"
#include "row_reader.hpp"

namespace binnacle::csv {

namespace {

/// Faults of the first pass: the first ends it, or all are counted.
class FirstFaults : public RowFaults {
 public:
  explicit FirstFaults(const Layout& layout) : layout_(layout) {}

  void refuse(const RowFault& fault, int line) override {
    if (layout_.on_invalid == OnInvalid::error)
      throw ComponentError::in_data(fault.message, layout_.format.path, line, fault.code);
    Skipped& skipped = skipped_[fault.code];
    if (skipped.count++ == 0) {
      skipped.first_line = line;
      skipped.first_message = fault.message;
    }
  }
  bool any() const { return !skipped_.empty(); }
  void report(Reporter& reporter) const {
    for (const auto& [code, skipped] : skipped_)
      reporter.warn(code, layout_.format.path, skipped.first_line,
                    count_of(skipped.count, "row") + " skipped" + (skipped.count == 1 ? ": " : ", the first: ") +
                        skipped.first_message);
  }

 private:
  struct Skipped {
    std::size_t count = 0;
    int first_line = 0;
    std::string first_message;
  };

  const Layout& layout_;
  std::map<std::string, Skipped> skipped_;
};

ComponentError changed(const Layout& layout, int line) {
  return ComponentError::in_data("the file has changed since it was opened: it has other rows now", layout.format.path,
                                 line, "B061");
}

}  // namespace

/// Faults of the second pass: what was read once without one has none.
class NoFaults : public RowFaults {
 public:
  explicit NoFaults(const Layout& layout) : layout_(layout) {}
  void refuse(const RowFault&, int line) override {
    if (layout_.on_invalid == OnInvalid::error) throw changed(layout_, line);
  }

 private:
  const Layout& layout_;
};

namespace {

std::size_t samples_of_block(const Layout& layout, const Limits& limits) {
  const std::size_t rows = layout.rows ? static_cast<std::size_t>(layout.rows->most) : 1;
  return std::max<std::size_t>(1, limits.block / (sizeof(double) * (layout.columns.size() * rows + 2)));
}

[[noreturn]] void require_samples(const Layout& layout, const Progress& progress, bool any_skipped, bool is_done) {
  std::string message = "no rows after the header";
  if (layout.format.where && progress.label_min == no_time && !any_skipped) message = no_such_row(*layout.format.where);
  if (any_skipped) {
    message = "no rows remain: all rows in the window were skipped";
  } else if (progress.label_min != no_time) {
    message = "no rows in the window; times run from " + time_text(progress.label_min + layout.time_offset) + " to " +
              time_text(progress.label_max + layout.time_offset) + (is_done ? " and on" : "");
  }
  throw ComponentError::in_data(message, layout.format.path, 0, "B066");
}

}  // namespace

class Table::Parts {
 public:
  Parts(const Layout& layout, const Limits& limits, Reporter& reporter)
      : layout_(layout),
        limits_(limits),
        later_faults_(layout),
        samples_of_block_(samples_of_block(layout, limits)),
        read_(limits.resident, [this](std::size_t k) { return read_again(k); }),
        thinned_(limits.resident, [this](std::size_t k) { return thin_again(k); }),
        lengths_(limits.step_values) {
    if (layout.max_gap) gaps_.emplace(*layout.max_gap);
    read_all(reporter);
    find_gaps(reporter);
    if (layout.every > 1) thin_all();
    if (read_.is_whole() || (layout.every > 1 && thinned_.is_whole())) let_go_of_file();
  }

  std::uint64_t size() const { return layout_.every > 1 ? thinned_count_ : count_; }

  void write(std::uint64_t i, SampleWriter& out) {
    const bool is_thinned = layout_.every > 1;
    std::size_t k = 0, in_block = 0;
    if (is_thinned) {
      k = static_cast<std::size_t>(std::ranges::upper_bound(thinned_begins_, i, {}, &ThinnedBegin::sample) -
                                   thinned_begins_.begin()) -
          1;
      in_block = static_cast<std::size_t>(i - thinned_begins_[k].sample);
    } else {
      k = static_cast<std::size_t>(i / samples_of_block_);
      in_block = static_cast<std::size_t>(i % samples_of_block_);
    }
    BlockStore& store = is_thinned ? thinned_ : read_;
    if (store.is_whole()) return write(store.kept(k), in_block, out);
    write(*store.get(k), in_block, out);
  }

 private:
  struct Mark {
    std::uint64_t offset;
    Time last_label, last_time;
    std::uint64_t checksum;
    int line;
  };
  struct ThinnedBegin {
    std::uint64_t sample;  // of those that are left
    std::uint64_t from;    // of those that were read
  };
  /// A reader that stands before a block.
  struct Cursor {
    std::size_t block;
    std::unique_ptr<RowReader> reader;
  };

  void write(const Block& block, std::size_t i, SampleWriter& out) const {
    out.t = block.times[i];
    out.t0 = start_of(block, i);
    const std::size_t width = layout_.columns.size(), begin = block.row_begin(i), end = block.row_end(i, width);
    const auto from = block.values.begin() + static_cast<std::ptrdiff_t>(begin * width);
    if (!layout_.rows) {
      std::copy_n(from, width, out.all().data());
      return;
    }
    out.rows = static_cast<int>(end - begin);
    std::copy_n(from, (end - begin) * width, out.row_view(0).data());
  }

  Time start_of(const Block& block, std::size_t i) const {
    if (!layout_.has_intervals) return no_time;
    if (!block.starts.empty()) return block.starts[i];
    const Time t = block.times[i], before = block.time_before(i);
    if (before == no_time) return layout_.interval ? t - *layout_.interval : no_time;
    if (t - before > max_gap_) return no_time;
    return layout_.interval ? t - *layout_.interval : before;
  }

  void read_all(Reporter& reporter) {
    FirstFaults faults(layout_);
    std::optional<RowReader> reader;
    try {
      reader.emplace(layout_, limits_, Standing{}, 0, &places_, faults);
      for (Block block;;) {
        const Standing from = reader->standing();
        if (!reader->fill(block, samples_of_block_)) break;
        add(from, std::move(block));
      }
    } catch (const text_file::FileFault& fault) {
      const std::size_t rows = reader ? reader->progress().rows : 0;
      throw ComponentError::in_data(fault.what() + ("; " + count_of(rows, "row")) + " could be read before",
                                    layout_.format.path, 0, fault.code);
    }
    width_ = reader->width();
    faults.report(reporter);
    if (reader->is_cut())
      reporter.warn("B061", layout_.format.path, reader->line(),
                    "the last line has no line end: the file and its last number may be truncated");
    if (count_ == 0) require_samples(layout_, reader->progress(), faults.any(), reader->is_done());
  }

  void add(const Standing& from, Block block) {
    marks_.push_back({from.place.offset, from.last_label, from.last_time, 0, from.place.line});
    count_ += block.size();
    if (gaps_)
      visit_steps(block, [&](const Step& step) { gaps_->add(step); });
    else if (layout_.has_intervals)
      visit_steps(block, [&](const Step& step) { lengths_.add(step); });
    if (read_.is_whole() && !read_.has_room_for(block)) {
      for (std::size_t k = 0; k < read_.count(); ++k) marks_[k].checksum = read_.kept(k).checksum();
      read_.let_go();
    }
    if (!read_.is_whole()) marks_.back().checksum = block.checksum();
    read_.add(std::move(block));
  }

  template <class Visitor>
  static void visit_steps(const Block& block, Visitor&& visit) {
    for (std::size_t i = block.before == no_time ? 1 : 0; i < block.size(); ++i) {
      const Time before = block.time_before(i);
      visit(Step{before, block.times[i] - before, block.lines[i]});
    }
  }

  void find_gaps(Reporter& reporter) {
    const auto pass = [&](const StepVisitor& visit) {
      for (std::size_t k = 0; k < read_.count(); ++k) visit_steps(*read_.get(k), visit);
    };
    if (gaps_) {
      max_gap_ = *layout_.max_gap;
    } else if (lengths_.count() > 0) {
      max_gap_ = 10 * std::min(lengths_.median(pass), std::numeric_limits<Time>::max() / 10);
      gaps_.emplace(max_gap_);
      if (!lengths_.collect(*gaps_)) pass([&](const Step& step) { gaps_->add(step); });
    }
    if (gaps_ && gaps_->any()) reporter.warn("B065", layout_.format.path, gaps_->line(), gaps_->message());
  }

  void thin_all() {
    const std::size_t most = std::max<std::size_t>(1, samples_of_block_ / static_cast<std::size_t>(layout_.every));
    Thinner thinner(layout_, 0);
    Block to;
    std::uint64_t next = 0, begin = 0;  // of those that were read
    const auto put = [&] {
      if (to.size() == 0) return;
      thinned_begins_.push_back({thinned_count_, begin});
      thinned_count_ += to.size();
      begin = next;
      if (thinned_.is_whole() && !thinned_.has_room_for(to)) thinned_.let_go();
      thinned_.add(std::exchange(to, {}));
    };
    for (std::size_t k = 0; k < read_.count(); ++k) {
      const auto from = read_.get(k);
      for (std::size_t i = 0; i < from->size(); ++i) {
        thinner.take(*from, i, start_of(*from, i), to);
        ++next;
        if (to.size() >= most && thinner.is_between()) put();
      }
    }
    thinner.finish(to);
    put();
  }

  Block thin_again(std::size_t k) {
    const ThinnedBegin& begin = thinned_begins_[k];
    const std::uint64_t end = k + 1 < thinned_begins_.size() ? thinned_begins_[k + 1].from : count_;
    Thinner thinner(layout_, begin.from);
    Block to;
    for (std::uint64_t i = begin.from; i < end;) {
      const auto from = read_.get(static_cast<std::size_t>(i / samples_of_block_));
      for (std::size_t j = i % samples_of_block_; j < from->size() && i < end; ++j, ++i)
        thinner.take(*from, j, start_of(*from, j), to);
    }
    thinner.finish(to);
    return to;
  }

  Block read_again(std::size_t k) {
    Block block;
    const Mark& mark = marks_[k];
    try {
      Cursor cursor = cursor_at(k);
      if (!cursor.reader->fill(block, samples_of_block_) || block.checksum() != mark.checksum)
        throw changed(layout_, mark.line + 1);
      ++cursor.block;
      put_back(std::move(cursor));
    } catch (const text_file::FileFault& fault) {
      throw ComponentError::in_data(fault.what(), layout_.format.path, 0, fault.code);
    }
    return block;
  }

  Cursor cursor_at(std::size_t k) {
    {
      const std::lock_guard lock(mutex_);
      const auto found = std::ranges::find(cursors_, k, &Cursor::block);
      if (found != cursors_.end()) {
        Cursor cursor = std::move(*found);
        cursors_.erase(found);
        return cursor;
      }
    }
    const Mark& mark = marks_[k];
    const Standing from{{mark.offset, mark.line}, mark.last_label, mark.last_time};
    return {k,
            std::make_unique<RowReader>(layout_, limits_, from, mark.line == 0 ? 0 : width_, &places_, later_faults_)};
  }

  /// Some are kept, each with an open file.
  void put_back(Cursor cursor) {
    constexpr std::size_t most = 4;
    Cursor oldest{};  // ends behind the lock
    const std::lock_guard lock(mutex_);
    cursors_.push_back(std::move(cursor));
    if (cursors_.size() <= most) return;
    oldest = std::move(cursors_.front());
    cursors_.erase(cursors_.begin());
  }

  void let_go_of_file() {
    if (layout_.every > 1) read_.let_go();
    marks_ = {};
    cursors_.clear();
    places_.clear();
  }

  const Layout& layout_;
  const Limits limits_;
  NoFaults later_faults_;
  std::size_t samples_of_block_;
  std::size_t width_ = 0;
  std::uint64_t count_ = 0, thinned_count_ = 0;
  std::vector<Mark> marks_;  // of each block that was read
  text_file::GzipPlaces places_;
  BlockStore read_, thinned_;
  std::vector<ThinnedBegin> thinned_begins_;
  StepCounts lengths_;
  std::optional<Gaps> gaps_;
  Time max_gap_ = std::numeric_limits<Time>::max();
  std::mutex mutex_;
  std::vector<Cursor> cursors_;
};

Table::Table(const Layout& layout, const Limits& limits, Reporter& reporter)
    : parts_(std::make_unique<Parts>(layout, limits, reporter)) {}

Table::~Table() = default;

std::uint64_t Table::size() const { return parts_->size(); }

void Table::write(std::uint64_t i, SampleWriter& out) const { parts_->write(i, out); }

}  // namespace binnacle::csv
