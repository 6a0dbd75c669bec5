// SPDX-License-Identifier: Apache-2.0
#include "tables.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include "wording/wording.hpp"

namespace binnacle::study {

using namespace wording;

namespace {

/// What a cell is made of, as its table, row and column say; `from` is where each stands.
struct Settings {
  std::map<std::string, std::string> texts, from;

  void add(const Settings& other) {
    for (const auto& [key, text] : other.texts) texts[key] = text;
    for (const auto& [key, pointer] : other.from) from[key] = pointer;
  }
  const std::string* find(const std::string& key) const {
    const auto found = texts.find(key);
    return found == texts.end() ? nullptr : &found->second;
  }
};

struct Header {
  std::string name, word;  // what is printed, and what stands for {row} or {column}
  std::string pointer;
  Settings settings;
  bool is_plain = true;
};

constexpr const char* reversed = "estimate - truth";

const std::vector<std::string> setting_keys{"metric", "statistic", "unit", "baseline", "show", "sign"};

Settings read_settings(const Section& section, const std::string& pointer, const std::string& cell_key) {
  Settings settings;
  const auto keep = [&](const std::string& as, const std::string& key) {
    const std::string at = join_pointer(pointer, key);
    if (const auto text = section.text(at)) {
      settings.texts[as] = *text;
      settings.from[as] = at;
    }
  };
  keep("cell", cell_key);
  for (const auto& key : setting_keys) keep(key, key);
  section.choice(join_pointer(pointer, "statistic"), over_runs_names());
  section.choice(join_pointer(pointer, "show"), {"value", "improvement", "ratio"});
  section.choice(join_pointer(pointer, "sign"), {"truth - estimate", reversed});
  return settings;
}

std::vector<Header> read_headers(const Section& section, const std::string& pointer, const char* what) {
  std::vector<Header> headers;
  const Json* list = section.list(pointer);
  if (!list) return headers;
  for (std::size_t i = 0; i < list->size(); ++i) {
    Header header;
    header.pointer = join_pointer(pointer, i);
    if ((*list)[i].is_object()) {
      std::vector<std::string> keys{"name", "as", "cell"};
      keys.insert(keys.end(), setting_keys.begin(), setting_keys.end());
      section.check_keys(header.pointer, keys, std::string("a ") + what + " of a table");
      header.is_plain = false;
      header.settings = read_settings(section, header.pointer, "cell");
      if (const auto name = section.text(join_pointer(header.pointer, "name")))
        header.name = *name;
      else
        section.error("B010", header.pointer, std::string("missing key 'name' of a ") + what + ": what is printed");
      header.word = section.text(join_pointer(header.pointer, "as")).value_or(header.name);
    } else if (const auto name = section.text(header.pointer)) {
      header.name = header.word = *name;
    }
    headers.push_back(std::move(header));
  }
  return headers;
}

std::string filled(std::string text, const Header& row, const Header& column) {
  const auto replace = [&text](const std::string& mark, const std::string& word) {
    for (auto at = text.find(mark); at != std::string::npos; at = text.find(mark, at + word.size()))
      text.replace(at, mark.size(), word);
  };
  replace("{row}", row.word);
  replace("{column}", column.word);
  return text;
}

class CellReader {
 public:
  CellReader(const Section& section, const std::string& table, const std::vector<std::string>& variants,
             const std::vector<StudyMetric>& metrics)
      : section_(section), table_(table), variants_(variants), metrics_(metrics) {
    const Json* texts = section.object(join_pointer(table, "texts"));
    if (!texts) return;
    for (const auto& [name, value] : texts->items())
      if (const auto text = section.text(join_pointer(join_pointer(table, "texts"), name))) texts_[name] = *text;
  }

  /// A text that no cell shows was meant for one.
  void tell_of_unused_texts() const {
    for (const auto& [name, text] : texts_)
      if (!used_texts_.contains(name))
        section_.key_error("B090", join_pointer(join_pointer(table_, "texts"), name),
                           "no cell of the table would be " + in_quotes(name));
  }

  Cell read(const Settings& settings, const Header& row, const Header& column) {
    Cell cell;
    if (auto text = texts_.find(filled(*settings.find("cell"), row, column)); text != texts_.end()) {
      cell.text = text->second;
      used_texts_.insert(text->first);
      return cell;
    }
    cell.variant = variant(settings, "cell", row, column);
    cell.metric = metric(settings);
    if (const auto* statistic = settings.find("statistic")) cell.statistic = over_runs_named(*statistic);
    if (cell.variant < 0) return cell;
    const auto* sign = settings.find("sign");
    cell.is_reversed = sign && *sign == reversed;
    const auto* show = settings.find("show");
    const bool has_baseline = settings.find("baseline") != nullptr;
    if (show ? *show == "improvement" : has_baseline) cell.show = Show::improvement;
    if (show && *show == "ratio") cell.show = Show::ratio;
    if (cell.show == Show::value) {
      cell.unit = unit(settings, cell.metric);
    } else if (has_baseline) {
      cell.baseline = variant(settings, "baseline", row, column);
      cell.unit = cell.show == Show::improvement ? "%" : "1";
    } else {
      report("B010", settings.from.at("show"),
             "an improvement or a ratio needs a 'baseline': the variant that it is compared with");
    }
    return cell;
  }

 private:
  /// Every cell of a row would say the same.
  void report(const std::string& code, const std::string& pointer, const std::string& message) {
    if (told_.insert(pointer + message).second) section_.error(code, pointer, message);
  }

  int variant(const Settings& settings, const std::string& key, const Header& row, const Header& column) {
    const std::string name = filled(*settings.find(key), row, column);
    if (name.empty()) return -1;
    const auto found = std::find(variants_.begin(), variants_.end(), name);
    if (found != variants_.end()) return static_cast<int>(found - variants_.begin());
    const auto from = settings.from.find(key);
    report("B090", from == settings.from.end() ? table_ : from->second,
           "there is no variant " + in_quotes(name) + ", the " + key + " of row " + in_quotes(row.name) + ", column " +
               in_quotes(column.name) + suggestion(name, variants_) + " (variants: " + listed(variants_) + ")");
    return -1;
  }

  int metric(const Settings& settings) {
    const auto* name = settings.find("metric");
    if (!name) {
      if (metrics_.size() != 1) report("B010", table_, "missing key 'metric' of the table: one of the study's metrics");
      return 0;
    }
    for (std::size_t i = 0; i < metrics_.size(); ++i)
      if (metrics_[i].name == *name) return static_cast<int>(i);
    return 0;  // reported where metrics are read
  }

  std::string unit(const Settings& settings, int index) {
    if (metrics_.empty()) return {};
    const auto& metric = metrics_[static_cast<std::size_t>(index)];
    const auto* wanted = settings.find("unit");
    if (!wanted) return metric.unit;
    score::Metric shown;
    shown.name = metric.name;
    shown.si_unit = metric.si_unit;
    if (const auto wrong = show_in(shown, *wanted); !wrong.empty())
      report(parse_unit(*wanted) ? "B007" : "B008", settings.from.at("unit"), wrong);
    return *wanted;
  }

  const Section& section_;
  const std::string& table_;
  const std::vector<std::string>& variants_;
  const std::vector<StudyMetric>& metrics_;
  std::set<std::string> told_;
  std::map<std::string, std::string> texts_;  // by what the cell would be
  std::set<std::string> used_texts_;
};

void read_paper(const Section& section, const std::string& pointer, TablePlan& plan) {
  const Json* rows = section.list(pointer);
  if (!rows) return;
  const auto has_size = [&](const Json& list, const std::string& at, std::size_t wanted, const char* what) {
    if (!list.is_array() || list.size() != wanted) {
      section.error("B013", at,
                    "'paper' has " + std::to_string(wanted) + " " + what + (wanted == 1 ? "" : "s") +
                        " here, as the table has; found " +
                        (list.is_array() ? std::to_string(list.size()) : list.dump()));
      return false;
    }
    return true;
  };
  if (!has_size(*rows, pointer, plan.rows.size(), "row")) return;
  for (std::size_t r = 0; r < rows->size(); ++r) {
    const std::string row_pointer = join_pointer(pointer, r);
    const Json& row = (*rows)[r];
    std::vector<double> figures(plan.columns.size(), std::numeric_limits<double>::quiet_NaN());
    if (has_size(row, row_pointer, plan.columns.size(), "column"))
      for (std::size_t c = 0; c < row.size(); ++c) {
        if (row[c].is_number())
          figures[c] = row[c].get<double>();
        else if (!row[c].is_null())
          section.error("B006", join_pointer(row_pointer, c), "a figure of the paper is a number or null");
      }
    plan.paper.push_back(std::move(figures));
  }
}

}  // namespace

std::vector<std::string> table_pointers(const Section& section, const std::string& place) {
  std::vector<std::string> pointers;
  for (const std::string& key : {place + "/table", place + "/tables"}) {
    const Json* value = section.at(key);
    if (value && value->is_array())
      for (std::size_t i = 0; i < value->size(); ++i) pointers.push_back(join_pointer(key, i));
    else if (value)
      pointers.push_back(key);
  }
  std::erase_if(pointers, [&](const std::string& pointer) { return !section.object(pointer); });
  return pointers;
}

std::vector<std::string> table_metric_pointers(const Section& section, const std::string& table) {
  std::vector<std::string> places{table};
  for (const char* key : {"rows", "columns"}) {
    const std::string pointer = join_pointer(table, key);
    const Json* list = section.at(pointer);
    if (list && list->is_array())
      for (std::size_t i = 0; i < list->size(); ++i)
        if ((*list)[i].is_object()) places.push_back(join_pointer(pointer, i));
  }
  std::vector<std::string> pointers;
  for (const auto& place : places)
    if (section.at(join_pointer(place, "metric"))) pointers.push_back(join_pointer(place, "metric"));
  return pointers;
}

TablePlan read_table(const Section& section, const std::string& pointer, const std::vector<std::string>& variants,
                     const std::vector<StudyMetric>& metrics) {
  TablePlan plan;
  std::vector<std::string> keys{"title", "rows", "columns", "cells", "texts", "paper", "errors"};
  keys.insert(keys.end(), setting_keys.begin(), setting_keys.end());
  section.check_keys(pointer, keys, "a table");
  plan.title = section.text(join_pointer(pointer, "title")).value_or("");
  plan.shows_errors = section.truth(join_pointer(pointer, "errors")).value_or(true);
  const Settings own = read_settings(section, pointer, "cells");
  auto rows = read_headers(section, join_pointer(pointer, "rows"), "row");
  auto columns = read_headers(section, join_pointer(pointer, "columns"), "column");
  const bool is_crossed = !columns.empty() && std::all_of(columns.begin(), columns.end(),
                                                          [](const Header& column) { return column.is_plain; });
  if (!section.at(join_pointer(pointer, "rows")))
    for (const auto& variant : variants) rows.push_back({variant, variant, pointer, {}, true});
  if (!section.at(join_pointer(pointer, "columns"))) {
    const auto* statistic = own.find("statistic");
    const std::string name = statistic ? *statistic : "rms";
    columns.push_back({name, name, pointer, {}, true});
  }
  for (const auto& column : columns) plan.columns.push_back(column.name);
  CellReader reader(section, pointer, variants, metrics);
  for (const auto& row : rows) {
    plan.rows.push_back(row.name);
    std::vector<Cell> cells;
    for (const auto& column : columns) {
      Settings settings;
      settings.texts["cell"] = is_crossed ? "{row} {column}" : "{row}";
      settings.add(own);
      settings.add(row.settings);
      settings.add(column.settings);
      cells.push_back(reader.read(settings, row, column));
    }
    plan.cells.push_back(std::move(cells));
  }
  reader.tell_of_unused_texts();
  read_paper(section, join_pointer(pointer, "paper"), plan);
  return plan;
}

}  // namespace binnacle::study
