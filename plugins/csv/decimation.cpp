// SPDX-License-Identifier: Apache-2.0
#include "decimation.hpp"

#include <algorithm>

namespace binnacle::csv {

namespace {

/// What stays of a table, sample by sample; each is written where no later one is still to be read.
class Thinner {
 public:
  Thinner(const Layout& layout, Table& table) : layout_(layout), table_(table), width_(layout.columns.size()) {}

  void keep_every() {
    const std::size_t every = static_cast<std::size_t>(layout_.every), lines = table_.values.size() / width_;
    const bool has_rows = !table_.begins.empty();
    std::size_t line = 0;
    for (std::size_t i = 0; i < table_.times.size(); i += every) {
      const std::size_t begin = has_rows ? table_.begins[i] : i;
      const std::size_t end = !has_rows ? i + 1 : i + 1 < table_.begins.size() ? table_.begins[i + 1] : lines;
      table_.times[kept_] = table_.times[i];
      if (has_rows) table_.begins[kept_] = line;
      std::copy(at(begin), at(end), at(line));
      line += end - begin;
      ++kept_;
    }
    if (has_rows) table_.begins.resize(kept_);
    cut(line);
  }

  void put_together() {
    for (std::size_t i = 0; i < table_.times.size();) {
      std::size_t end = i + 1;
      if (table_.starts[i] != no_time)
        while (end < table_.times.size() && end - i < static_cast<std::size_t>(layout_.every) &&
               table_.starts[end] != no_time)
          ++end;
      join(i, end);
      i = end;
    }
    table_.starts.resize(kept_);
    cut(kept_);
  }

 private:
  std::vector<double>::iterator at(std::size_t line) {
    return table_.values.begin() + static_cast<std::ptrdiff_t>(line * width_);
  }

  void cut(std::size_t lines) {
    table_.times.resize(kept_);
    table_.values.resize(lines * width_);
  }

  /// The samples from first to before end.
  void join(std::size_t first, std::size_t end) {
    const Time start = table_.starts[first], t = table_.times[end - 1];
    for (std::size_t c = 0; c < width_; ++c) {
      const FieldKind kind = layout_.columns[c].kind;
      double sum = 0, seconds_in_all = 0;
      for (std::size_t i = first; i < end; ++i) {
        const double value = table_.values[i * width_ + c], length = seconds(table_.times[i] - table_.starts[i]);
        sum += kind == FieldKind::rate ? value * length : value;
        seconds_in_all += length;
      }
      const bool is_whole = end - first == 1 || kind == FieldKind::level;
      table_.values[kept_ * width_ + c] = is_whole                  ? table_.values[(end - 1) * width_ + c]
                                          : kind == FieldKind::rate ? sum / seconds_in_all
                                                                    : sum;
    }
    table_.starts[kept_] = start;
    table_.times[kept_] = t;
    ++kept_;
  }

  const Layout& layout_;
  Table& table_;
  std::size_t width_;
  std::size_t kept_ = 0;
};

}  // namespace

void thin_out(const Layout& layout, Table& table) {
  Thinner thinner(layout, table);
  if (table.starts.empty())
    thinner.keep_every();
  else
    thinner.put_together();
}

}  // namespace binnacle::csv
