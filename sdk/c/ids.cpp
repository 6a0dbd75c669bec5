// SPDX-License-Identifier: Apache-2.0
#include "handles.hpp"

namespace binnacle::c {

namespace {

constexpr int number_shift = 40, kind_shift = 36, filter_shift = 20;
constexpr std::uint64_t number_mask = 0xffffff, kind_mask = 0xf, filter_mask = 0xffff, index_mask = 0xfffff;

const char* noun_of(std::uint64_t kind) {
  constexpr const char* nouns[] = {"nothing", "a channel", "a filter", "a block", "a measurement"};
  return nouns[kind < std::size(nouns) ? kind : 0];
}

struct Place {
  int filter = -1, index = -1;
};

Place place_of(std::uint64_t number, IdKind wanted, binnacle_id id) {
  const std::uint64_t kind = id >> kind_shift & kind_mask;
  if (kind != static_cast<std::uint64_t>(wanted))
    throw UsageError(std::string("the id of ") + noun_of(static_cast<std::uint64_t>(wanted)) +
                     " is wanted; this is that of " + noun_of(kind));
  if (id >> number_shift != (number & number_mask))
    throw UsageError(std::string("this id of ") + noun_of(kind) + " is of another composition");
  return {static_cast<int>(id >> filter_shift & filter_mask), static_cast<int>(id & index_mask)};
}

}  // namespace

binnacle_id id_of(std::uint64_t number, IdKind kind, int filter, int index) {
  const auto f = static_cast<std::uint64_t>(filter), i = static_cast<std::uint64_t>(index);
  if (f > filter_mask || i > index_mask) throw std::length_error("the composition has too many parts for an id");
  return (number & number_mask) << number_shift | static_cast<std::uint64_t>(kind) << kind_shift | f << filter_shift |
         i;
}

ChannelId channel_of(std::uint64_t number, binnacle_id id) { return {place_of(number, IdKind::channel, id).index}; }

FilterId filter_of(std::uint64_t number, binnacle_id id) { return {place_of(number, IdKind::filter, id).index}; }

BlockId block_of(std::uint64_t number, binnacle_id id) {
  const Place place = place_of(number, IdKind::block, id);
  return {{place.filter}, place.index};
}

MeasurementId measurement_of(std::uint64_t number, binnacle_id id) {
  const Place place = place_of(number, IdKind::measurement, id);
  return {{place.filter}, place.index};
}

}  // namespace binnacle::c
