// SPDX-License-Identifier: Apache-2.0
// Labels of one channel: span, rate, jitter, gaps, duplicates, time going back, their unit, their time base.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "questions.hpp"
#include "statistics.hpp"

namespace binnacle::inspect {

namespace {

Finding finding(const Channel& channel, std::string kind, double value, std::string unit, Severity severity) {
  Finding found;
  found.kind = std::move(kind);
  found.channel = channel.name;
  found.value = value;
  found.unit = std::move(unit);
  found.severity = severity;
  return found;
}

void ask_steps(const Channel& channel, double step, Findings& findings) {
  const auto& t = channel.t;
  double span = 0;
  for (const double label : t)
    if (std::isfinite(label)) span = std::max(span, label);
  Finding rate = finding(channel, "rate", 1 / step, "Hz", Severity::finding);
  rate.text = fmt::format("{} samples in {} s, one every {} s", t.size(), figure(span), figure(step));
  rate.evidence = "median step of the labels";
  rate.from = 0;
  rate.to = span;
  findings.push_back(std::move(rate));

  std::vector<double> steps;
  for (std::size_t i = 1; i < t.size(); ++i)
    if (t[i] > t[i - 1] && t[i] - t[i - 1] < 3 * step) steps.push_back(t[i] - t[i - 1] - step);
  const double jitter = std::max(robust_sigma(steps), 0.0) / std::sqrt(2.0);
  // A uniform error of half a step is 0.29 of it: beyond a tenth the label does not belong to the sample any more.
  const bool is_bad = jitter > 0.1 * step;
  Finding found = finding(channel, "jitter", jitter, "s", is_bad ? Severity::warning : Severity::finding);
  found.text =
      fmt::format("labels scatter by {} s (1 sigma), {} % of a step", figure(jitter), figure(100 * jitter / step));
  found.evidence = fmt::format("robust scatter of {} steps, over sqrt(2)", steps.size());
  if (is_bad) found.meaning = source_patch(channel, {{"interval", fmt::format("{} s", figure(step))}});
  findings.push_back(std::move(found));
}

/// The longest of the kind is named, with how many there are.
struct Worst {
  std::size_t count = 0, row = 0;
  double size = 0, sum = 0;
  void add(double its_size, std::size_t its_row) {
    ++count;
    sum += its_size;
    if (its_size > size) {
      size = its_size;
      row = its_row;
    }
  }
};

void report_gaps(const Channel& channel, const Worst& gaps, double step, Findings& findings) {
  if (gaps.count == 0) return;
  Finding found = finding(channel, "gap", gaps.size, "s", Severity::warning);
  found.from = channel.t[gaps.row - 1];
  found.to = channel.t[gaps.row];
  found.text = fmt::format("{} gap{} longer than {} s, {} s in all; the longest, {} s, begins at {} s", gaps.count,
                           gaps.count == 1 ? "" : "s", figure(10 * step), figure(gaps.sum), figure(gaps.size),
                           figure(found.from));
  found.evidence = "steps beyond ten times the median";
  findings.push_back(std::move(found));
}

}  // namespace

void ask_stamps(const Channel& channel, Findings& findings) {
  const auto& t = channel.t;
  if (channel.bad_labels > 0) {
    Finding found = finding(channel, "nan", static_cast<double>(channel.bad_labels), "", Severity::warning);
    found.field = channel.time_column;
    found.text = fmt::format(
        "{} of {} labels are no number and no date with a time of day (ISO 8601); for dates, times and weeks in "
        "separate columns, see: binnacle describe csv",
        channel.bad_labels, t.size());
    found.evidence = "cells of the column of times";
    findings.push_back(std::move(found));
  }
  const double step = usual_step(t);
  if (!(step > 0)) return;
  ask_steps(channel, step, findings);
  Worst gaps, equal, back;
  double newest = t.front();
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] == t[i - 1])
      equal.add(1, i);
    else if (t[i] < t[i - 1])
      back.add(t[i - 1] - t[i], i);
    else if (t[i] - newest > 10 * step)
      gaps.add(t[i] - newest, i);
    if (t[i] > newest) newest = t[i];
  }
  report_gaps(channel, gaps, step, findings);
  if (equal.count > 0) {
    Finding found = finding(channel, "duplicate", static_cast<double>(equal.count), "", Severity::warning);
    found.from = found.to = t[equal.row];
    found.text = fmt::format("{} labels stand twice, the first at {} s", equal.count, figure(found.from));
    found.evidence = "equal labels of successive rows";
    found.meaning = source_patch(channel, {{"invalid_rows", "skip"}});
    findings.push_back(std::move(found));
  }
  if (back.count > 0) {
    Finding found = finding(channel, "time_back", -back.size, "s", Severity::warning);
    found.from = found.to = t[back.row - 1];
    found.text = fmt::format("time goes back {} time{}, by {} s at {} s", back.count, back.count == 1 ? "" : "s",
                             figure(back.size), figure(found.from));
    found.evidence = "a label before the one in the row above";
    found.meaning = source_patch(channel, {{"invalid_rows", "skip"}});
    findings.push_back(std::move(found));
  }
  if (channel.cut_rows > 0) {
    Finding found = finding(channel, "cut_row", static_cast<double>(channel.cut_rows), "", Severity::warning);
    found.text = fmt::format("{} row{} of another number of cells", channel.cut_rows, channel.cut_rows == 1 ? "" : "s");
    found.evidence = "cells of a row against most rows";
    if (10 * channel.cut_rows > static_cast<std::int64_t>(t.size()))
      found.text += ": if lines are of several kinds, \"where\" of the source 'csv' takes one of them";
    else
      found.meaning = source_patch(channel, {{"invalid_rows", "skip"}});
    findings.push_back(std::move(found));
  }
}

double label_factor(const Channel& channel, Findings& findings) {
  const double step = usual_step(channel.t);
  if (!(step > 0)) return 1;
  // What is recorded of each kind of sensor: 4 Hz to 10 kHz, 0.02 Hz to 200 Hz. Units differ by thousands, the bands by less.
  const double longest = channel.is_inertial() ? 0.3 : 50, shortest = channel.is_inertial() ? 1e-4 : 5e-3;
  double factor = 1;
  while (step * factor > longest && factor > 1e-9) factor *= 1e-3;
  while (step * factor < shortest && factor < 1e9) factor *= 1e3;
  if (factor != 1 && (channel.is_inertial() || channel.is_fix())) {
    const double unit = file_unit(channel.time_unit).scale * factor;
    const char* const name = unit > 0.5 ? "s" : unit > 0.5e-3 ? "ms" : unit > 0.5e-6 ? "us" : "ns";
    Finding found =
        finding(channel, "time_unit", unit, "s", channel.time_is_guessed ? Severity::finding : Severity::warning);
    found.text = fmt::format("labels are in {}, not {}: {} samples a second otherwise", name, channel.time_unit,
                             figure(1 / step));
    found.evidence =
        fmt::format("median step {} {}", figure(step / file_unit(channel.time_unit).scale), channel.time_unit);
    found.confidence = 0.99;
    found.meaning = source_patch(channel, {{"time", {{"unit", name}}}});
    findings.push_back(std::move(found));
  }
  const double label = channel.first_label * factor;
  Finding base = finding(channel, "time_base", label, "s", Severity::finding);
  const bool is_receiver = !channel.type.empty() && channel.type != "csv";
  base.text =
      channel.has_dates
          ? "labels are dates and times of day (ISO 8601): UTC where they state no zone, counted as GPS time from 1980"
      : is_receiver      ? "labels are the time that the source gives: of GPS unless it is set otherwise"
      : label > 1.4504e9 ? "labels count from 1970 (Unix, UTC without leap seconds): GPS seconds are not that many yet"
      : label > 3e8      ? "labels count from 1970 (Unix) or from 1980 (GPS): both are possible"
      : label > 604800   ? "labels count from an epoch that no receiver uses"
      : label > 20000    ? "labels may be seconds of the GPS week or of the day"
                         : "labels count from the beginning of the record";
  base.evidence = fmt::format("first label {:.3f} s", label);
  base.from = base.to = 0;
  findings.push_back(std::move(base));
  return factor;
}

}  // namespace binnacle::inspect
