// SPDX-License-Identifier: Apache-2.0
// Sessions: samples in, estimates out, snapshots.
#include "binnacle/session.hpp"

#include <algorithm>
#include <utility>

#include "handles.hpp"

namespace binnacle::c {

namespace {

/// Times whose differences do not overflow.
void check_time(std::int64_t t, const char* name) {
  if (t < -BINNACLE_LAST_TIME || t > BINNACLE_LAST_TIME)
    throw UsageError(std::string(name) + " is " + std::to_string(t) + " ns; times lie within 2^62 ns of 0");
}

void check_times(std::int64_t t0, std::int64_t t) {
  check_time(t, "t");
  if (t0 != no_time) check_time(t0, "t0");
}

void check_run(std::int32_t run) {
  if (run < 0) throw UsageError("run is " + std::to_string(run) + "; runs count from 0");
}

void check_count(std::uint64_t count, std::uint64_t wanted, const std::string& what) {
  if (count != wanted)
    throw UsageError(what + " has " + std::to_string(wanted) + " numbers; there are " + std::to_string(count));
}

std::vector<SampleShape> shapes_of(const Composition& composition) {
  std::vector<SampleShape> shapes;
  for (const ChannelInfo& channel : composition.channels()) {
    const ChannelDeclaration& declaration = *channel.declaration;
    const auto rows = declaration.covariance.size();
    shapes.push_back({static_cast<std::uint64_t>(declaration.count(false)),
                      static_cast<std::uint64_t>(declaration.count(true)),
                      static_cast<std::uint64_t>(declaration.max_rows), rows * rows});
  }
  return shapes;
}

/// Rows that so many numbers are; throws where they are not whole rows, or too many.
int rows_of(const SampleShape& shape, std::uint64_t count) {
  if (count == 0) return 0;
  const std::uint64_t width = shape.row_fields;
  if (width == 0 || count % width != 0 || count / width > shape.max_rows)
    throw UsageError("sample->row_field_count is " + std::to_string(count) + "; this channel takes up to " +
                     std::to_string(shape.max_rows) + " rows of " + std::to_string(width) + " fields");
  return static_cast<int>(count / width);
}

/// A sample as the session takes it; it points into the caller's arrays.
SampleView view_of(const OpenSession& open, ChannelId channel, const binnacle_sample* given) {
  const binnacle_sample sample = taken(given, "sample");
  check_times(sample.t0, sample.t);
  if (static_cast<std::size_t>(channel.index) >= open.shapes.size()) throw UsageError("there is no such channel");
  const SampleShape& shape = open.shapes[static_cast<std::size_t>(channel.index)];
  if (sample.field_count != shape.fields) check_count(sample.field_count, shape.fields, "sample->fields");
  SampleView view;
  view.t = sample.t;
  view.t0 = sample.t0;
  view.rows = rows_of(shape, sample.row_field_count);
  view.fields = sample.fields;
  view.row_fields = sample.row_fields;
  view.covariance = sample.covariance;
  view.available = true;
  if (sample.covariance ? sample.covariance_count != shape.covariance || shape.covariance == 0
                        : sample.covariance_count != 0)
    throw UsageError("sample->covariance_count is " + std::to_string(sample.covariance_count) +
                     "; this channel takes a covariance of " + std::to_string(shape.covariance) + " numbers, or none");
  return view;
}

/// A whole matrix, column by column.
void copy(ConstMatrixView from, double* into, std::uint64_t count) {
  const auto size = static_cast<std::uint64_t>(from.rows) * static_cast<std::uint64_t>(from.cols);
  if (count != size) check_count(count, size, "this covariance");
  if (count > 0) not_null(into, "P");
  for (int column = 0; column < from.cols; ++column)
    for (int row = 0; row < from.rows; ++row) *into++ = from(row, column);
}

std::span<double> room(double* into, std::uint64_t count, const char* name) {
  if (count > 0) not_null(into, name);
  return {into, static_cast<std::size_t>(count)};
}

/// Calls a look-up of Session; a name that is unknown is wrong usage.
template <class Lookup>
auto found(const char* name, Lookup&& lookup) {
  not_null(name, "name");
  try {
    return lookup(name);
  } catch (const ConfigError& error) {
    throw UnknownName(error);
  }
}

void give_text(OpenSession& open, const char** text, auto&& made) {
  not_null(text, "text");
  std::string fresh = made();
  open.text = std::move(fresh);
  *text = open.text.c_str();
}

}  // namespace

}  // namespace binnacle::c

using namespace binnacle;
using namespace binnacle::c;

binnacle_status binnacle_open(const binnacle_composition* composition, uint64_t seed, int32_t run,
                              binnacle_session** session) {
  return guarded(__func__, [&] {
    const auto& in = content_of(composition);
    not_null(session, "session");
    check_run(run);
    auto open = std::make_unique<OpenSession>(
        OpenSession{in.number, Session(in.composition, seed, run), shapes_of(*in.composition), {}});
    *session = reinterpret_cast<binnacle_session*>(&slots<OpenSession>().take(std::move(open)));
  });
}

binnacle_status binnacle_close(binnacle_session* session) {
  return guarded(__func__, [&] { close(session); });
}

binnacle_status binnacle_reset(binnacle_session* session, uint64_t seed, int32_t run) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    check_run(run);
    open.session.reset(seed, run);
  });
}

// ---- names

binnacle_status binnacle_find_channel(const binnacle_session* session, const char* name, binnacle_id* channel) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    const auto id = found(name, [&](const char* text) { return open.session.channel(text); });
    not_null(channel, "channel") = id_of(open.number, IdKind::channel, 0, id.index);
  });
}

binnacle_status binnacle_find_filter(const binnacle_session* session, const char* name, binnacle_id* filter) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    const auto id = found(name, [&](const char* text) { return open.session.filter(text); });
    not_null(filter, "filter") = id_of(open.number, IdKind::filter, 0, id.index);
  });
}

binnacle_status binnacle_find_block(const binnacle_session* session, const char* name, binnacle_id* block) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    const auto id = found(name, [&](const char* text) { return open.session.block(text); });
    not_null(block, "block") = id_of(open.number, IdKind::block, id.filter.index, id.index);
  });
}

binnacle_status binnacle_find_measurement(const binnacle_session* session, const char* name, binnacle_id* measurement) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    const auto id = found(name, [&](const char* text) { return open.session.measurement(text); });
    not_null(measurement, "measurement") = id_of(open.number, IdKind::measurement, id.filter.index, id.index);
  });
}

// ---- in

binnacle_status binnacle_push(binnacle_session* session, binnacle_id channel, int64_t t0, int64_t t,
                              const double* fields, uint64_t count) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    const ChannelId to = channel_of(open.number, channel);
    check_times(t0, t);
    if (count > 0) not_null(fields, "fields");
    open.session.push(to, t0, t, {fields, static_cast<std::size_t>(count)});
  });
}

binnacle_status binnacle_push_sample(binnacle_session* session, binnacle_id channel, const binnacle_sample* sample) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    const ChannelId to = channel_of(open.number, channel);
    open.session.push(to, view_of(open, to, sample));
  });
}

binnacle_status binnacle_add(binnacle_session* session, binnacle_id channel, const binnacle_sample* sample) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    const ChannelId to = channel_of(open.number, channel);
    open.session.add(to, view_of(open, to, sample));
  });
}

binnacle_status binnacle_commit(binnacle_session* session, int64_t t) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    check_time(t, "t");
    open.session.commit(t);
  });
}

// ---- out

binnacle_status binnacle_read(const binnacle_session* session, binnacle_id block, double* outputs, uint64_t count) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    open.session.read(block_of(open.number, block), room(outputs, count, "outputs"));
  });
}

binnacle_status binnacle_read_sigma(const binnacle_session* session, binnacle_id block, double* sigmas,
                                    uint64_t count) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    open.session.read_sigma(block_of(open.number, block), room(sigmas, count, "sigmas"));
  });
}

binnacle_status binnacle_read_block_covariance(const binnacle_session* session, binnacle_id block, double* P,
                                               uint64_t count) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    copy(open.session.covariance(block_of(open.number, block)), P, count);
  });
}

binnacle_status binnacle_read_covariance(const binnacle_session* session, binnacle_id filter, double* P,
                                         uint64_t count) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    copy(open.session.covariance(filter_of(open.number, filter)), P, count);
  });
}

binnacle_status binnacle_read_state(const binnacle_session* session, binnacle_id filter, double* state,
                                    uint64_t count) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    const auto from = open.session.state(filter_of(open.number, filter));
    if (count != from.size()) check_count(count, from.size(), "this state");
    std::ranges::copy(from, room(state, count, "state").begin());
  });
}

binnacle_status binnacle_read_time(const binnacle_session* session, binnacle_id filter, int64_t* t) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    not_null(t, "t") = open.session.time(filter_of(open.number, filter));
  });
}

binnacle_status binnacle_read_start_time(const binnacle_session* session, binnacle_id filter, int64_t* t) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    not_null(t, "t") = open.session.start_time(filter_of(open.number, filter));
  });
}

binnacle_status binnacle_read_started(const binnacle_session* session, binnacle_id filter, int32_t* is_so) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    not_null(is_so, "is_so") = open.session.started(filter_of(open.number, filter)) ? 1 : 0;
  });
}

binnacle_status binnacle_read_healthy(const binnacle_session* session, binnacle_id filter, int32_t* is_so) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    not_null(is_so, "is_so") = open.session.healthy(filter_of(open.number, filter)) ? 1 : 0;
  });
}

binnacle_status binnacle_read_verdict(const binnacle_session* session, binnacle_id filter, binnacle_verdict* verdict) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    const Verdict found = open.session.verdict(filter_of(open.number, filter));
    not_null(verdict, "verdict") = static_cast<binnacle_verdict>(found);
  });
}

const char* binnacle_verdict_name(binnacle_verdict verdict) {
  const bool is_known = verdict >= BINNACLE_VERDICT_OK && verdict <= BINNACLE_VERDICT_LOST;
  return is_known ? verdict_name(static_cast<Verdict>(verdict)) : nullptr;
}

binnacle_status binnacle_diagnosis(binnacle_session* session, binnacle_id filter, const char** text) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    give_text(open, text, [&] { return open.session.diagnosis(filter_of(open.number, filter)); });
  });
}

binnacle_status binnacle_reasons(binnacle_session* session, binnacle_id filter, const char** text) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    give_text(open, text, [&] { return open.session.doubts(filter_of(open.number, filter)).text(); });
  });
}

binnacle_status binnacle_reasons_json(binnacle_session* session, binnacle_id filter, const char** json) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    give_text(open, json, [&] { return json_text(open.session.doubts(filter_of(open.number, filter))); });
  });
}

binnacle_status binnacle_last_reason(binnacle_session* session, binnacle_id measurement, const char** text) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    give_text(open, text, [&] { return open.session.counts(measurement_of(open.number, measurement)).last_reason; });
  });
}

binnacle_status binnacle_count_samples(const binnacle_session* session, binnacle_id measurement,
                                       binnacle_counts* counts) {
  return guarded(__func__, [&] {
    check_size(counts, "counts");
    const auto& open = content_of(session);
    const MeasurementCounts found = open.session.counts(measurement_of(open.number, measurement));
    const auto of = [&](Outcome outcome) { return found.by_outcome[static_cast<int>(outcome)]; };
    static_assert(outcome_count == 7, "a further outcome needs a place in binnacle_counts");
    binnacle_counts content{};
    content.offered = found.offered;
    content.accepted = of(Outcome::accepted);
    content.gated = of(Outcome::gated);
    content.late = of(Outcome::late);
    content.unsupported = of(Outcome::unsupported);
    content.invalid = of(Outcome::invalid);
    content.withheld = of(Outcome::withheld);
    content.rejected = of(Outcome::rejected);
    content.before_start = found.before_start;
    content.recoveries = found.recoveries;
    content.rows_used = found.rows_used;
    content.rows_left_out = found.rows_left_out;
    content.nis_mean = found.nis_mean;
    content.dof_mean = found.dof_mean;
    give(counts, content);
  });
}

// ---- snapshots

binnacle_status binnacle_snapshot_size(const binnacle_session* session, uint64_t* bytes) {
  return guarded(__func__, [&] { not_null(bytes, "bytes") = content_of(session).session.snapshot_size(); });
}

binnacle_status binnacle_snapshot(const binnacle_session* session, void* into, uint64_t bytes) {
  return guarded(__func__, [&] {
    const auto& open = content_of(session);
    if (bytes > 0) not_null(static_cast<std::byte*>(into), "into");
    open.session.snapshot({static_cast<std::byte*>(into), static_cast<std::size_t>(bytes)});
  });
}

binnacle_status binnacle_restore(binnacle_session* session, const void* from, uint64_t bytes) {
  return guarded(__func__, [&] {
    auto& open = content_of(session);
    if (bytes > 0) not_null(static_cast<const std::byte*>(from), "from");
    open.session.restore({static_cast<const std::byte*>(from), static_cast<std::size_t>(bytes)});
  });
}
