// SPDX-License-Identifier: Apache-2.0
#include "open_session.hpp"

#include <stdexcept>
#include <utility>

namespace binnacle::python {

namespace {

std::vector<SampleShape> shapes_of(const Composition& composition) {
  std::vector<SampleShape> shapes;
  for (const ChannelInfo& channel : composition.channels()) {
    SampleShape& shape = shapes.emplace_back();
    shape.name = channel.name;
    for (const FieldSpec& field : channel.declaration->fields)
      (field.is_per_row ? shape.row_fields : shape.fields).push_back(field.name);
    for (const NamedUnit& component : channel.declaration->covariance) shape.covariance.push_back(component.name);
    shape.max_rows = channel.declaration->max_rows;
  }
  return shapes;
}

/// A look-up of Session; a name that is unknown is a KeyError here.
template <class Lookup>
auto found(Lookup&& lookup) {
  try {
    return lookup();
  } catch (const ConfigError& error) {
    throw py::key_error(error.diagnostics().items().front().message);
  }
}

}  // namespace

OpenSession::OpenSession(std::shared_ptr<const Composition> composition, std::uint64_t seed, int run,
                         Estimates estimates)
    : session(std::move(composition), seed, run, estimates), shapes(shapes_of(session.composition())) {}

int OpenSession::channel(std::string_view name) {
  std::string key(name);
  if (const auto known = channels_.find(key); known != channels_.end()) return known->second;
  const int index = found([&] { return session.channel(name); }).index;
  channels_.emplace(std::move(key), index);
  return index;
}

BlockId OpenSession::block(std::string_view name) {
  std::string key(name);
  if (const auto known = blocks_.find(key); known != blocks_.end()) return known->second;
  const BlockId id = found([&] { return session.block(name); });
  blocks_.emplace(std::move(key), id);
  return id;
}

MeasurementId OpenSession::measurement(std::string_view name) {
  return found([&] { return session.measurement(name); });
}

FilterId OpenSession::filter(std::string_view name) const {
  if (!name.empty()) return found([&] { return session.filter(name); });
  const auto& filters = session.composition().filters();
  if (filters.size() == 1) return {0};
  std::string names;
  for (const auto& filter : filters) names += (names.empty() ? "" : ", ") + filter.name;
  throw py::value_error("which filter? This composition has " +
                        (filters.empty() ? std::string("none") : std::to_string(filters.size()) + ": " + names));
}

void Busy::refuse() {
  throw std::runtime_error(
      "this session is in another call, of another thread or of the model that calls it: a session serves one thread "
      "at a "
      "time; open one for each (any number may share a composition)");
}

}  // namespace binnacle::python
