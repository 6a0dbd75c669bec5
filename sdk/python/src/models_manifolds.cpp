// SPDX-License-Identifier: Apache-2.0
#include "models_manifolds.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "binnacle/catalog.hpp"
#include "binnacle/composition.hpp"
#include "models.hpp"

namespace binnacle::python {

Manifold::Manifold(std::string kind, int stored_size, const std::vector<NamedUnit>& components)
    : kind_(std::move(kind)),
      stored_size_(stored_size),
      is_vector_(kind_.starts_with("vector:") && stored_size == static_cast<int>(components.size())) {
  for (const auto& component : components) units_.push_back(component.unit);
}

void Manifold::move(const double* x, int component, double size, double* moved) const {
  if (!block_) {
    std::copy_n(x, stored_size_, moved);
    moved[component] += size;
    return;
  }
  std::vector<double> delta(static_cast<std::size_t>(dof()), 0.0);
  delta[static_cast<std::size_t>(component)] = size;
  block_->plus({x, stored_size_}, delta, {moved, stored_size_});
}

void Manifold::minus(const double* y, const double* x, double* delta) const {
  if (block_)
    block_->minus({y, stored_size_}, {x, stored_size_}, {delta, dof()});
  else
    for (int i = 0; i < stored_size_; ++i) delta[i] = y[i] - x[i];
}

double Manifold::step(const double* x, int component) const {
  const std::string& unit = units_[static_cast<std::size_t>(component)];
  if (unit.starts_with("rad")) return 1e-4;
  if (is_vector_) return 1e-3 * std::max(1.0, std::abs(x[component]));
  return unit == "m" ? 0.1 : 1e-2;
}

void OnManifolds::add_manifold(const PortBinding& block) {
  manifolds_->emplace_back(block.kind, block.stored_size, block.components);
}

class ManifoldBinder {
 public:
  explicit ManifoldBinder(const FilterInfo& filter) : filter_(filter) {}

  template <class Base>
  void bind(const BoundInfo<Base>& info, const char* role) {
    const auto* const model = dynamic_cast<const OnManifolds*>(info.object.get());
    if (!model || !info.type || info.type->plugin != plugin_of_models) return;
    marks_.push_back({{"component", info.name}, {"role", role}, {"type", info.type->full_name()}});
    auto& manifolds = *model->manifolds_;
    for (std::size_t i = 0; i < manifolds.size(); ++i)
      manifolds[i].set(block_on(i < info.ports.size() ? info.ports[i] : -1, manifolds[i].kind()));
  }
  nlohmann::ordered_json marks() const { return marks_; }

 private:
  /// Of a derived value (and of what one yields), a block of the kind.
  std::shared_ptr<const StateBlock> block_on(int value, const std::string& kind) const {
    if (value >= 0 && value < static_cast<int>(filter_.blocks.size()))
      return filter_.blocks[static_cast<std::size_t>(value)].block;
    for (const auto& block : filter_.blocks)
      if (block.declaration->kind == kind) return block.block;
    return nullptr;
  }

  const FilterInfo& filter_;
  nlohmann::ordered_json marks_ = nlohmann::ordered_json::array();
};

namespace {

class Marks final : public SectionData {
 public:
  explicit Marks(std::vector<nlohmann::ordered_json> by_filter) : by_filter_(std::move(by_filter)) {}
  std::string explain(int filter) const override {
    const auto& marks = by_filter_[static_cast<std::size_t>(filter)];
    return marks.empty() ? "" : nlohmann::ordered_json{{"written_in_python", marks}}.dump();
  }

 private:
  std::vector<nlohmann::ordered_json> by_filter_;
};

class Manifolds final : public Section {
 public:
  std::vector<std::string> keys() const override { return {}; }
  std::shared_ptr<const SectionData> read(CompositionDraft& draft) const override {
    if (draft.has_errors()) return nullptr;
    std::vector<nlohmann::ordered_json> marks;
    for (const auto& filter : draft.filters()) {
      ManifoldBinder binder(filter);
      for (const auto& process : filter.processes) binder.bind<ProcessModel>(process, "process model");
      for (const auto& derived : filter.derived) binder.bind(derived, "derived block");
      for (const auto& measurement : filter.measurements) {
        for (const auto& part : measurement.parts) binder.bind(part, "measurement model");
        binder.bind(measurement.noise, "noise estimator");
      }
      marks.push_back(binder.marks());
    }
    return std::make_shared<Marks>(std::move(marks));
  }
};

}  // namespace

std::shared_ptr<const Section> manifolds_section() { return std::make_shared<const Manifolds>(); }

}  // namespace binnacle::python
