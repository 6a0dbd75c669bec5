// SPDX-License-Identifier: Apache-2.0
#include "figures.hpp"

#include <algorithm>
#include <cmath>

#include "binnacle/state_block.hpp"
#include "binnacle/time.hpp"
#include "binnacle/unit.hpp"
#include "wording/wording.hpp"

namespace binnacle::observe {

using namespace wording;
using Json = nlohmann::ordered_json;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// What the block declares; angles and their rates as people read them where it declares nothing.
std::string display_unit(const StateBlockDeclaration& block, const std::string& unit) {
  if (!block.error_display_unit.empty()) return block.error_display_unit;
  return unit == "rad" ? "deg" : unit == "rad/s" ? "deg/h" : unit;
}

/// Seconds after the window's begin; null where it does not happen.
template <class Is>
Json first_time(const Stay& stay, Is is) {
  for (const auto& entry : stay.history.entries())
    if (is(entry.removed)) return seconds(entry.t - stay.from);
  return nullptr;
}

/// "attitude.down with gyro_bias.y", "a, b and 2 more".
std::string name_of(const Direction& direction, const std::vector<RowName>& rows) {
  constexpr std::size_t most = 3;
  const auto& parts = direction.parts;
  std::string name = rows[as_size(parts[0].row)].name;
  if (parts.size() == 2) return name + " with " + rows[as_size(parts[1].row)].name;
  if (parts.size() > 2) name += " with ";
  for (std::size_t i = 1; i < std::min(parts.size(), most); ++i)
    name += (i == 1 ? "" : ", ") + rows[as_size(parts[i].row)].name;
  if (parts.size() > most) name += " and " + std::to_string(parts.size() - most) + " more";
  return name;
}

Json parts_json(const Direction& direction, const std::vector<RowName>& rows) {
  Json list = Json::array();
  for (const Part& part : direction.parts) {
    const RowName& row = rows[as_size(part.row)];
    list.push_back({{"component", row.name},
                    {"displacement", part.displacement / row.scale},
                    {"unit", row.unit},
                    {"share", part.share},
                    {"of_before", part.of_before}});
  }
  return list;
}

Json components_json(const Stay& stay, const FilterInfo& filter, const std::vector<RowName>& rows) {
  const MatrixXd& W = stay.with_noise.root();
  const VectorXd before = W.cwiseAbs2().rowwise().sum();
  const VectorXd after = variances_left(W, stay.with_noise.removed());
  const VectorXd noiseless = variances_left(W, stay.without_noise.removed());
  Json components = Json::object();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto k = static_cast<Index>(i);
    if (!(before[k] > 0)) continue;
    const RowName& row = rows[i];
    Json& component = components[row.name];
    component = {{"unit", row.unit},
                 {"before", std::sqrt(before[k]) / row.scale},
                 {"after", std::sqrt(after[k]) / row.scale},
                 {"removed", 1 - after[k] / before[k]},
                 {"removed_without_process_noise", 1 - noiseless[k] / before[k]}};
    component["known_after_s"] = first_time(stay, [&](const MatrixXd& D) {
      const double left = before[k] - W.row(k).dot(W.row(k) * D);
      return left <= (1 - known_share) * before[k];
    });
    Json& by = component["by"] = Json::object();
    for (std::size_t m = 0; m < filter.measurements.size(); ++m)
      by[filter.measurements[m].name] =
          W.row(k).dot(W.row(k) * stay.with_noise.removed_by(static_cast<int>(m))) / before[k];
    if (row.is_considered) component["considered"] = true;
  }
  return components;
}

Json weak_json(const Stay& stay, const std::vector<RowName>& rows) {
  Json list = Json::array();
  for (const Direction& direction : weak_directions(stay.with_noise.root(), stay.with_noise.removed())) {
    const VectorXd& u = direction.along;
    list.push_back({{"name", name_of(direction, rows)},
                    {"removed", std::max(0.0, u.dot(stay.with_noise.removed() * u))},
                    {"removed_without_process_noise", std::max(0.0, u.dot(stay.without_noise.removed() * u))},
                    {"parts", parts_json(direction, rows)}});
  }
  return list;
}

Json inconsistent_json(const Stay& stay, const MatrixXd& on_path, const std::vector<RowName>& rows) {
  Json list = Json::array();
  const Information& claimed = stay.with_noise;
  for (const auto& direction : spurious_directions(claimed.root(), claimed.removed(), on_path)) {
    const VectorXd& u = direction.along;
    list.push_back({{"name", name_of(direction, rows)},
                    {"claimed", direction.claimed},
                    {"removed", std::max(0.0, direction.removed)},
                    {"since_s", first_time(stay,
                                           [&](const MatrixXd& D) {
                                             return 1 - u.dot(D * u) < known_share * (1 - direction.removed);
                                           })},
                    {"parts", parts_json(direction, rows)}});
  }
  return list;
}

Json notes_json(const Stay& stay) {
  Json notes = Json::array();
  if (stay.restarted) notes.push_back("the filter started anew: what came after is a window of its own");
  if (stay.opened > 0)
    notes.push_back("P was opened " + std::to_string(stay.opened) + " times for samples that were refused");
  if (stay.singular > 0)
    notes.push_back(std::to_string(stay.singular) + " samples have an S that is not positive definite: left out");
  return notes;
}

}  // namespace

std::vector<RowName> rows_of(const FilterInfo& filter) {
  std::vector<RowName> rows;
  for (const BlockInfo& block : filter.blocks)
    for (const int component : block.active) {
      const NamedUnit& error = block.declaration->error[as_size(component)];
      RowName row;
      row.name = block.name + "." + error.name;
      row.unit = display_unit(*block.declaration, error.unit);
      const auto unit = parse_unit(row.unit);
      row.scale = unit ? unit->scale : 1;
      row.is_considered = block.use[as_size(component)] == "considered";
      rows.push_back(std::move(row));
    }
  return rows;
}

Json figures_of(const Stay& stay, const OnePath& path, const FilterInfo& filter) {
  const std::vector<RowName> rows = rows_of(filter);
  Json samples = Json::object();
  for (const auto& measurement : filter.measurements) samples[measurement.name] = 0;
  for (const Accepted& sample : stay.accepted)
    samples[filter.measurements[as_size(sample.measurement)].name] =
        samples[filter.measurements[as_size(sample.measurement)].name].get<int>() + 1;
  Json figures{{"window", stay.name}, {"from_s", seconds(stay.from)}, {"to_s", seconds(stay.to)}, {"samples", samples}};
  figures["components"] = components_json(stay, filter, rows);
  figures["singular_values"] = singular_values(stay.with_noise.removed());
  figures["weak"] = weak_json(stay, rows);
  if (path.why_not.empty())
    figures["inconsistent"] = inconsistent_json(stay, path.removed, rows);
  else
    figures["not_checked"] = path.why_not;
  figures["notes"] = notes_json(stay);
  return figures;
}

}  // namespace binnacle::observe
