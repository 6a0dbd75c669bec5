// SPDX-License-Identifier: Apache-2.0
#include "sparsity_svg.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>

#include "table.hpp"
#include "text_of.hpp"
#include "wording/markup.hpp"

namespace binnacle::command {

namespace {

constexpr double margin = 24, gap = 36;
constexpr double letter = 6.3;  // width of one at the font's 11 px, about
constexpr double line_height = 17;

/// Readable on white and on black.
constexpr const char* hues[] = {"#3b7dd8", "#2f9e63", "#8e63ce", "#d9822b", "#1f9aa8", "#cf4f5f", "#7d8a2e", "#b0609b"};

const char* const svg_style = R"(  <style>
    text { font: 11px system-ui, "DejaVu Sans", sans-serif; fill: #1c2430; }
    .title { font-size: 15px; font-weight: 600; }
    .head { font-size: 13px; font-weight: 600; }
    .block { font-weight: 600; }
    .minor { fill: #667080; }
    .considered { font-style: italic; }
    .paper { fill: #ffffff; }
    .panel { fill: #f6f8fa; stroke: #8b96a5; }
    .grid { stroke: #8b96a5; stroke-opacity: 0.22; }
    .edge { stroke: #8b96a5; stroke-opacity: 0.75; }
    .identity { fill: none; stroke: #667080; }
    .h { fill: #c78a1b; }
    @media (prefers-color-scheme: dark) {
      text { fill: #e4e9f0; }
      .minor { fill: #9aa5b4; }
      .paper { fill: #14181e; }
      .panel { fill: #1c222b; }
      .identity { stroke: #9aa5b4; }
    }
  </style>
)";

/// Characters, not bytes.
double width_of(const std::string& text) {
  return letter *
         static_cast<double>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string text(double x, double y, const std::string& what, const std::string& kind = "",
                 const std::string& more = "") {
  return fmt::format("  <text x=\"{:.1f}\" y=\"{:.1f}\"{}{}>{}</text>\n", x, y,
                     kind.empty() ? "" : " class=\"" + kind + "\"", more.empty() ? "" : " " + more, wording::xml(what));
}

std::string segment(double x1, double y1, double x2, double y2, const char* kind) {
  return fmt::format("  <line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\"/>\n", x1, y1, x2, y2,
                     kind);
}

struct Component {
  std::string name, unit;
  bool is_considered = false;
};

/// A block with its rows of P.
struct Rows {
  std::string name, moved_by;
  int first = 0;
  std::vector<Component> components;
  int count() const { return static_cast<int>(components.size()); }
};

class FilterDrawing {
 public:
  FilterDrawing(const Json& filter, double top) : filter_(filter), top_(top) {
    read_layout();
    measure();
    draw();
  }
  const std::string& svg() const { return svg_; }
  double right() const { return right_; }
  double bottom() const { return bottom_; }

 private:
  void read_layout() {
    for (const auto& block : filter_.at("blocks")) {
      Rows rows;
      rows.name = text_of(block, "name");
      rows.moved_by = text_of(block, "advanced_by");
      std::vector<std::string> frozen;
      for (const auto& component : block.at("components")) {
        if (!component.contains("row")) {
          frozen.push_back(text_of(component, "name"));
          continue;
        }
        if (rows.components.empty()) rows.first = component.at("row").get<int>();
        rows.components.push_back(
            {text_of(component, "name"), text_of(component, "unit"), text_of(component, "use") == "considered"});
      }
      if (!frozen.empty()) frozen_.push_back(rows.name + " (" + joined(frozen) + ")");
      if (rows.components.empty()) continue;
      n_ += rows.count();
      blocks_.push_back(std::move(rows));
    }
    for (const auto& process : filter_.at("process")) {
      const std::string name = text_of(process, "name");
      types_[name] = text_of(process, "type");
      hue_[name] = hues[hue_.size() % std::size(hues)];
    }
  }

  void measure() {
    cell_ = n_ <= 30 ? 16 : n_ <= 60 ? 11 : std::max(2.0, 660.0 / n_);
    double names = 0, components = 0, strips = width_of("sees no block");
    for (const auto& block : blocks_) {
      names = std::max(names, width_of(block.name) * 1.1);
      for (const auto& component : block.components) components = std::max(components, width_of(label(component)));
    }
    for (const auto& measurement : filter_.at("measurements"))
      for (const auto& part : measurement.at("parts"))
        strips = std::max(strips, width_of(strip_name(measurement, part)) * 1.1);
    names_ = margin + names;
    left_ = std::max(names_ + (has_component_labels() ? components + 24 : 12), margin + strips + 12);
    names_ = left_ - (has_component_labels() ? components + 24 : 12);
    double narrowest = side();
    for (const auto& block : blocks_) narrowest = std::min(narrowest, cell_ * block.count());
    slope_ = narrowest < 24 ? 60 : 40;
    heads_ = 0;
    for (const auto& block : blocks_) heads_ = std::max(heads_, width_of(block.name) * std::sin(slope_ / 57.3));
    matrix_top_ = top_ + 2.4 * line_height + heads_ + 14;
    noise_left_ = left_ + side() + std::max(gap, overhang() + 12);
  }

  /// Of column heads to the right of their matrix.
  double overhang() const {
    double over = 0;
    for (const auto& block : blocks_)
      over = std::max(over, width_of(block.name) * std::cos(slope_ / 57.3) -
                                cell_ * (n_ - block.first - block.count() / 2.0));
    return over;
  }
  bool has_component_labels() const { return cell_ >= 10; }
  double side() const { return cell_ * n_; }
  static std::string label(const Component& component) {
    return component.name + (component.unit.empty() || component.unit == "1" ? "" : " [" + component.unit + "]") +
           (component.is_considered ? ", considered" : "");
  }
  static std::string strip_name(const Json& measurement, const Json& part) {
    const std::string name = text_of(measurement, "name"), own = text_of(part, "name");
    return own.empty() || own == name ? name : name + "." + own;
  }
  const Rows* block_named(const std::string& name) const {
    for (const auto& block : blocks_)
      if (block.name == name) return &block;
    return nullptr;
  }

  void draw() {
    svg_ += text(margin, top_ + line_height,
                 fmt::format("Filter {}: {} in the covariance", text_of(filter_, "name"),
                             counted(static_cast<std::size_t>(n_), "row")),
                 "title");
    if (n_ == 0) {
      right_ = bottom_ = top_ + line_height;
      return draw_frozen();
    }
    draw_labels();
    draw_matrix(left_, "Transition Φ", "phi", filter_.at("transition"), "to", "from");
    draw_matrix(noise_left_, "Noise Qd", "qd", filter_.at("noise"), "row", "column");
    draw_movers();
    bottom_ = matrix_top_ + side();
    draw_strips();
    draw_notes();
  }

  void draw_labels() {
    for (const auto& block : blocks_) {
      const double y = matrix_top_ + cell_ * block.first;
      if (cell_ * block.count() >= 9)
        svg_ += text(names_, y + (has_component_labels() ? cell_ / 2 : cell_ * block.count() / 2) + 4, block.name,
                     "block", "text-anchor=\"end\"");
      if (!has_component_labels()) continue;
      for (int i = 0; i < block.count(); ++i) {
        const auto& component = block.components[static_cast<std::size_t>(i)];
        svg_ += text(left_ - 10, y + cell_ * (i + 0.5) + 4, label(component),
                     component.is_considered ? "minor considered" : "minor", "text-anchor=\"end\"");
      }
    }
  }

  void draw_heads(double x) {
    for (const auto& block : blocks_) {
      if (cell_ * block.count() < 9) continue;
      const double at = x + cell_ * (block.first + block.count() / 2.0) + 2, y = matrix_top_ - 6;
      svg_ += text(at, y, block.name, "minor", fmt::format("transform=\"rotate(-{} {:.1f} {:.1f})\"", slope_, at, y));
    }
  }

  void draw_grid(double x, double y, double height) {
    if (cell_ >= 8)
      for (int i = 1; i < n_; ++i) svg_ += segment(x + cell_ * i, y, x + cell_ * i, y + height, "grid");
    for (const auto& block : blocks_)
      if (block.first > 0) svg_ += segment(x + cell_ * block.first, y, x + cell_ * block.first, y + height, "edge");
  }

  void fill(double x, const std::string& kind, const Rows& row, const Rows& column, const std::string& structure) {
    const auto hue = hue_.find(row.moved_by);
    const std::string paint =
        structure == "identity" || hue == hue_.end() ? "" : fmt::format(" style=\"fill: {}\"", hue->second);
    const std::string caption = row.name + " of " + column.name + ": " + structure +
                                (row.moved_by.empty() ? "" : ", filled by " + row.moved_by);
    const auto rectangle = [&](int first_row, int first_column, int rows, int columns) {
      const double inset = structure == "identity" ? 0.28 * cell_ : structure == "diagonal" ? 0.12 * cell_ : 0.5;
      svg_ += fmt::format(
          "  <rect class=\"{} {}\"{} x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"1.5\" "
          "data-row=\"{}\" "
          "data-column=\"{}\" data-rows=\"{}\" data-columns=\"{}\"><title>{}</title></rect>\n",
          kind, structure, paint, x + cell_ * first_column + inset, matrix_top_ + cell_ * first_row + inset,
          cell_ * columns - 2 * inset, cell_ * rows - 2 * inset, first_row, first_column, rows, columns,
          wording::xml(caption));
    };
    if (structure == "dense") return rectangle(row.first, column.first, row.count(), column.count());
    for (int i = 0; i < std::min(row.count(), column.count()); ++i) rectangle(row.first + i, column.first + i, 1, 1);
  }

  void draw_matrix(double x, const std::string& title, const std::string& kind, const Json& blocks, const char* row_key,
                   const char* column_key) {
    svg_ += text(x, top_ + 2.3 * line_height, title, "head");
    draw_heads(x);
    svg_ += fmt::format("  <rect class=\"panel\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n", x,
                        matrix_top_, side(), side());
    for (const auto& entry : blocks) {
      const Rows* row = block_named(text_of(entry, row_key));
      const Rows* column = block_named(text_of(entry, column_key));
      if (row && column) fill(x, kind, *row, *column, text_of(entry, "structure"));
    }
    draw_grid(x, matrix_top_, side());
    if (cell_ >= 8)
      for (int i = 1; i < n_; ++i)
        svg_ += segment(x, matrix_top_ + cell_ * i, x + side(), matrix_top_ + cell_ * i, "grid");
    for (const auto& block : blocks_)
      if (block.first > 0)
        svg_ += segment(x, matrix_top_ + cell_ * block.first, x + side(), matrix_top_ + cell_ * block.first, "edge");
  }

  /// Who fills the rows.
  void draw_movers() {
    const double x = noise_left_ + side() + std::max(14.0, overhang() > 14 ? 20.0 : 14.0);
    right_ = noise_left_ + side() + overhang();
    for (std::size_t first = 0, end; first < blocks_.size(); first = end) {
      for (end = first + 1; end < blocks_.size() && blocks_[end].moved_by == blocks_[first].moved_by;) ++end;
      const auto& block = blocks_[first];
      const int rows = blocks_[end - 1].first + blocks_[end - 1].count() - block.first;
      if (cell_ * rows < 9) continue;
      const double top = matrix_top_ + cell_ * block.first, height = cell_ * rows;
      const bool is_moved = hue_.contains(block.moved_by);
      const std::string caption =
          is_moved ? block.moved_by + " (" + types_.at(block.moved_by) + ")" : "moved by nothing";
      const std::string paint = is_moved ? fmt::format("style=\"fill: {}\"", hue_.at(block.moved_by)) : "";
      if (is_moved)
        svg_ += fmt::format("  <rect {} x=\"{:.1f}\" y=\"{:.1f}\" width=\"3\" height=\"{:.1f}\"/>\n", paint, x - 6,
                            top + 1, height - 2);
      svg_ += text(x + 4, top + height / 2 + 4, caption, is_moved ? "" : "minor", paint);
      right_ = std::max(right_, x + 4 + width_of(caption));
    }
  }

  void draw_strips() {
    if (filter_.at("measurements").empty()) return;
    bottom_ += gap;
    svg_ += text(left_, bottom_ - 10, "Measurements H", "head");
    const double height = std::max(cell_, 14.0);
    for (const auto& measurement : filter_.at("measurements")) {
      bool is_first = true;
      for (const auto& part : measurement.at("parts")) {
        svg_ +=
            text(left_ - 10, bottom_ + height / 2 + 4, strip_name(measurement, part), "block", "text-anchor=\"end\"");
        svg_ += fmt::format("  <rect class=\"panel\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"/>\n",
                            left_, bottom_, side(), height);
        for (const auto& name : part.at("columns"))
          if (const Rows* block = block_named(name.get<std::string>())) fill_strip(measurement, part, *block, height);
        draw_grid(left_, bottom_, height);
        std::string caption = text_of(part, "type");
        if (is_first)
          caption += fmt::format(", on {}, up to {}", text_of(measurement, "channel"),
                                 counted(measurement.at("max_rows").get<std::size_t>(), "row"));
        svg_ += text(left_ + side() + 14, bottom_ + height / 2 + 4, caption, "minor");
        right_ = std::max(right_, left_ + side() + 14 + width_of(caption));
        bottom_ += height + 4;
        is_first = false;
      }
    }
  }

  void fill_strip(const Json& measurement, const Json& part, const Rows& block, double height) {
    svg_ += fmt::format(
        "  <rect class=\"h dense\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" rx=\"1.5\" "
        "data-measurement=\"{}\" data-part=\"{}\" data-column=\"{}\" data-columns=\"{}\"><title>{}</title></rect>\n",
        left_ + cell_ * block.first + 0.5, bottom_ + 0.5, cell_ * block.count() - 1, height - 1,
        wording::xml(text_of(measurement, "name")), wording::xml(text_of(part, "name")), block.first, block.count(),
        wording::xml(strip_name(measurement, part) + " sees " + block.name));
  }

  void draw_notes() {
    bottom_ += 1.6 * line_height;
    double x = left_;
    const auto key = [&](const std::string& kind, double width, double height, const std::string& meaning) {
      svg_ += fmt::format("  <rect {} x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.0f}\" height=\"{:.0f}\" rx=\"1.5\"/>\n",
                          kind, x, bottom_ - 4 - height / 2, width, height);
      svg_ += text(x + width + 7, bottom_, meaning, "minor");
      x += width + 27 + width_of(meaning);
    };
    const std::string paint = fmt::format("style=\"fill: {}\"", hues[0]);
    key(paint, 18, 12, "dense");
    key(paint, 10, 10, "diagonal");
    key("class=\"key identity\"", 8, 8, "1: stays as it is");
    svg_ += text(x, bottom_, "empty: zero and not computed", "minor");
    right_ = std::max(right_, x + width_of("empty: zero and not computed"));
    draw_frozen();
  }

  void draw_frozen() {
    if (!frozen_.empty()) {
      bottom_ += 1.3 * line_height;
      const double x = n_ == 0 ? margin : left_;
      const std::string caption = "Frozen, without a row: " + joined(frozen_);
      svg_ += text(x, bottom_, caption, "minor");
      right_ = std::max(right_, x + width_of(caption));
    }
    bottom_ += line_height;
  }

  const Json& filter_;
  double top_;
  std::vector<Rows> blocks_;
  std::vector<std::string> frozen_;
  std::map<std::string, std::string> types_, hue_;  // of processes
  int n_ = 0;
  double slope_ = 40;  // of column heads [deg]
  double cell_ = 16, names_ = 0, left_ = 0, heads_ = 0, matrix_top_ = 0, noise_left_ = 0, right_ = 0, bottom_ = 0;
  std::string svg_;
};

}  // namespace

std::string sparsity_svg(const Json& explained) {
  std::string drawings;
  double bottom = 8, right = 320;
  if (const std::string title = text_of(explained, "title"); !title.empty()) {
    drawings += text(margin, bottom + line_height, title, "minor");
    right = std::max(right, margin + width_of(title));
    bottom += line_height;
  }
  for (const auto& filter : explained.at("filters")) {
    const FilterDrawing drawing(filter, bottom + 10);
    drawings += drawing.svg();
    bottom = drawing.bottom();
    right = std::max(right, drawing.right());
  }
  const double width = std::ceil(right + margin), height = std::ceil(bottom + 8);
  return fmt::format(
             "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" "
             "height=\"{1}\" viewBox=\"0 0 {0} {1}\">\n{2}  <rect class=\"paper\" width=\"{0}\" height=\"{1}\"/>\n",
             width, height, svg_style) +
         drawings + "</svg>\n";
}

}  // namespace binnacle::command
