// SPDX-License-Identifier: Apache-2.0
// Rest: when the sensor stands, and what it shows then: bias, noise, the direction of gravity; vibration against it.
#include <algorithm>
#include <cmath>
#include <complex>

#include <fmt/format.h>

#include "questions.hpp"
#include "statistics.hpp"

namespace binnacle::inspect {

namespace {

constexpr const char* rate_names[] = {"wx", "wy", "wz"};
constexpr const char* force_names[] = {"fx", "fy", "fz"};

/// At rest with the engine on, specific force scatters by some tenths of this; on a foot that walks by more [m/s^2].
constexpr double most_at_rest = 1;

/// One second.
struct Bin {
  std::size_t first, end;
  double scatter_w, scatter_f;
  Vector3d mean_w, mean_f;
  bool moves = false;
};

Bin bin_of(const Inertial& inertial, std::size_t first, std::size_t end) {
  Bin bin{first, end, 0, 0, Vector3d::Zero(), Vector3d::Zero()};
  double count = 0;
  for (std::size_t i = first; i < end; ++i) {
    if (!inertial.w[i].allFinite() || !inertial.f[i].allFinite()) continue;
    bin.mean_w += inertial.w[i];
    bin.mean_f += inertial.f[i];
    ++count;
  }
  bin.mean_w /= count;
  bin.mean_f /= count;
  for (std::size_t i = first; i < end; ++i) {
    if (!inertial.w[i].allFinite() || !inertial.f[i].allFinite()) continue;
    bin.scatter_w += (inertial.w[i] - bin.mean_w).squaredNorm();
    bin.scatter_f += (inertial.f[i] - bin.mean_f).squaredNorm();
  }
  bin.scatter_w = std::sqrt(bin.scatter_w / count);
  bin.scatter_f = std::sqrt(bin.scatter_f / count);
  return bin;
}

std::vector<Bin> bins_of(const Inertial& inertial) {
  std::vector<Bin> bins;
  for (std::size_t first = 0; first < inertial.t.size();) {
    std::size_t end = first + 1;
    while (end < inertial.t.size() && inertial.t[end] < inertial.t[first] + 1) ++end;
    if (static_cast<double>(end - first) * inertial.step > 0.7) bins.push_back(bin_of(inertial, first, end));
    first = end;
  }
  return bins;
}

void mark_moving(std::vector<Bin>& bins, const Inertial& inertial, const Fixes& fixes, double delay) {
  std::size_t k = 0;
  for (Bin& bin : bins) {
    const double from = inertial.t[bin.first] + delay - 1, to = inertial.t[bin.end - 1] + delay + 1;
    while (k < fixes.t.size() && fixes.t[k] < from) ++k;
    for (std::size_t i = k; i < fixes.t.size() && fixes.t[i] <= to; ++i)
      bin.moves |= std::hypot(fixes.v[i][0], fixes.v[i][1]) > 0.3;
  }
}

}  // namespace

RestFigures find_rest(const Inertial& inertial, const Fixes* fixes, double delay) {
  RestFigures rest;
  std::vector<Bin> bins = bins_of(inertial);
  rest.is_seen = fixes && fixes->has_velocity;
  if (rest.is_seen) mark_moving(bins, inertial, *fixes, delay);
  for (Bin& bin : bins) bin.moves |= bin.scatter_f > most_at_rest;
  std::vector<double> w, f;
  for (const Bin& bin : bins) {
    if (bin.moves) continue;
    w.push_back(bin.scatter_w);
    f.push_back(bin.scatter_f);
  }
  if (w.size() < 3) return rest;
  // The quietest seconds of the record set the scale; rounding to zero scatter counts as quiet.
  const double limit_w = 4 * quantile(w, 0.05) + 1e-12, limit_f = 4 * quantile(f, 0.05) + 1e-12;
  double n = 0;
  Vector3d square_w = Vector3d::Zero(), square_f = Vector3d::Zero();
  rest.mean_w = rest.mean_f = Vector3d::Zero();
  for (std::size_t i = 0; i < bins.size(); ++i) {
    std::size_t end = i;
    while (end < bins.size() && !bins[end].moves && bins[end].scatter_w < limit_w && bins[end].scatter_f < limit_f)
      ++end;
    if (end - i >= 3) {
      rest.spans.push_back({inertial.t[bins[i].first], inertial.t[bins[end - 1].end - 1]});
      for (std::size_t b = i; b < end; ++b)
        for (std::size_t k = bins[b].first; k < bins[b].end; ++k) {
          if (!inertial.w[k].allFinite() || !inertial.f[k].allFinite()) continue;
          rest.mean_w += inertial.w[k];
          rest.mean_f += inertial.f[k];
          square_w += (inertial.w[k] - bins[b].mean_w).cwiseAbs2();
          square_f += (inertial.f[k] - bins[b].mean_f).cwiseAbs2();
          ++n;
        }
      i = end;
    }
  }
  if (n == 0) return rest;
  rest.mean_w /= n;
  rest.mean_f /= n;
  rest.sigma_w = (square_w / n).cwiseSqrt();
  rest.sigma_f = (square_f / n).cwiseSqrt();
  rest.seconds = n * inertial.step;
  return rest;
}

void ask_rest(const Channel& channel, const Inertial& inertial, const RestFigures& rest, Findings& findings) {
  Finding found;
  found.channel = channel.name;
  found.kind = "rest";
  found.unit = "s";
  found.value = rest.seconds;
  found.evidence = "seconds whose scatter is within four times that of the quietest twentieth";
  if (rest.spans.empty()) {
    found.severity = Severity::unknown;
    found.text = "there is no rest of three seconds: bias and noise at rest cannot be given";
    findings.push_back(std::move(found));
    return;
  }
  found.from = rest.spans.front().from;
  found.to = rest.spans.back().to;
  const char* const when = rest.is_seen ? "at rest" : "while quiet";
  found.text = fmt::format("{} for {} s in {} span{}; the first from {} s to {} s",
                           rest.is_seen ? "at rest" : "quiet, at rest or moving evenly,", figure(rest.seconds),
                           rest.spans.size(), rest.spans.size() == 1 ? "" : "s", figure(rest.spans.front().from),
                           figure(rest.spans.front().to));
  findings.push_back(found);
  const auto add = [&](const char* kind, const char* field, double value, const char* unit, std::string text,
                       const char* evidence) {
    Finding more = found;
    more.kind = kind;
    more.field = field;
    more.value = value;
    more.unit = unit;
    more.text = std::move(text);
    more.evidence = fmt::format(fmt::runtime(evidence), figure(rest.seconds));
    findings.push_back(std::move(more));
  };
  const double root = std::sqrt(inertial.step);
  for (int k = 0; k < 3; ++k)
    add("rate_bias", rate_names[k], rest.mean_w[k], "rad/s",
        fmt::format("{} deg/s {}, noise {} deg/s ({} deg/sqrt(h) if it is white)", figure(rest.mean_w[k] * 57.29578),
                    when, figure(rest.sigma_w[k] * 57.29578), figure(rest.sigma_w[k] * root * 57.29578 * 60)),
        "mean over {} s of rest; for the noise, use binnacle allan");
  for (int k = 0; k < 3; ++k)
    add("force_noise", force_names[k], rest.sigma_f[k], "m/s^2",
        fmt::format("mean {} m/s^2 {}, noise {} m/s^2", figure(rest.mean_f[k]), when, figure(rest.sigma_f[k])),
        "{} s of rest");
  const double gravity = rest.mean_f.norm();
  int up = 0;
  rest.mean_f.cwiseAbs().maxCoeff(&up);
  add("gravity", "fx, fy, fz", gravity, "m/s^2",
      fmt::format("|f| is {} m/s^2 {}; up is {}{}, {} deg off that axis", figure(gravity), when,
                  rest.mean_f[up] > 0 ? "+" : "-", "xyz"[up],
                  figure(57.29578 * std::acos(std::min(1.0, std::abs(rest.mean_f[up]) / gravity)))),
      "mean specific force over {} s of rest");
}

namespace {

/// What the forces along x have pushed from the end of rest until the vehicle is under way [m/s]: backwards, it is below zero.
double push_off(const Inertial& inertial, double from, double to, double at_rest, const Matrix3d& C_vb) {
  double push = 0;
  for (std::size_t i = 0; i < inertial.t.size() && inertial.t[i] < to; ++i)
    if (inertial.t[i] > from && inertial.f[i].allFinite())
      push += ((C_vb.row(0) * inertial.f[i]).value() - at_rest) * inertial.step;
  return push;
}

}  // namespace

std::optional<Start> start_of(const Inertial& inertial, const Fixes& fixes, double delay, const RestFigures& rest,
                              const Matrix3d& C_vb) {
  // Ten seconds: levelling takes the mean of two, and the noise of a sample is then known to a few percent.
  if (!rest.is_seen || rest.spans.empty() || rest.spans.front().from > inertial.t.front() + 5) return std::nullopt;
  const Rest& first = rest.spans.front();
  Start start{first.to - first.from, rest.sigma_w.maxCoeff(), rest.sigma_f.maxCoeff(), 0, 0};
  if (start.seconds < 10) return std::nullopt;
  start.gyro_noise = start.gyro_scatter * std::sqrt(inertial.step);
  start.force_noise = start.force_scatter * std::sqrt(inertial.step);
  const double under_way = std::max(3.0, fixes.moving);
  for (std::size_t i = 0; i < fixes.t.size(); ++i) {
    const double t = fixes.t[i] - delay;
    if (t < first.to || std::hypot(fixes.v[i][0], fixes.v[i][1]) < under_way) continue;
    // A drive that begins so much later has not begun with this rest.
    if (t > first.to + 120) return std::nullopt;
    const double push = push_off(inertial, first.to, t, (C_vb.row(0) * rest.mean_f).value(), C_vb);
    return push > 0.5 * under_way ? std::optional(start) : std::nullopt;
  }
  return std::nullopt;
}

namespace {

/// The strongest frequency of |f| above 2 Hz, by the mean periodogram of stretches of 256 samples [Hz], and its rms.
std::pair<double, double> strongest(const Inertial& inertial) {
  constexpr std::size_t n = 256;
  std::vector<double> power(n / 2, 0);
  double stretches = 0;
  const std::size_t hop = std::max<std::size_t>(n, inertial.f.size() / 200);
  for (std::size_t first = 0; first + n <= inertial.f.size(); first += hop) {
    if (inertial.t[first + n - 1] - inertial.t[first] > 1.1 * n * inertial.step) continue;
    for (std::size_t k = 2; k < n / 2; ++k) {
      std::complex<double> sum = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const double window = 1 - std::cos(6.283185307 * static_cast<double>(i) / n);
        const double length = inertial.f[first + i].norm();
        sum += (std::isfinite(length) ? length - 9.8 : 0) * window *
               std::polar(1.0, -6.283185307 * static_cast<double>(k * i % n) / n);
      }
      power[k] += std::norm(sum);
    }
    ++stretches;
  }
  if (stretches == 0) return {0, 0};
  std::size_t best = static_cast<std::size_t>(std::max(2.0, std::ceil(2 * inertial.step * n)));
  for (std::size_t k = best; k < n / 2; ++k)
    if (power[k] > power[best]) best = k;
  // Hann: an amplitude A at one line gives |sum| = A n / 2.
  return {static_cast<double>(best) / (n * inertial.step), 2 * std::sqrt(power[best] / stretches) / n / std::sqrt(2.0)};
}

}  // namespace

void ask_vibration(const Channel& channel, const Inertial& inertial, const RestFigures& rest, Findings& findings) {
  const auto [frequency, rms] = strongest(inertial);
  if (frequency == 0) return;
  Finding found;
  found.channel = channel.name;
  found.kind = "vibration";
  found.field = "fx, fy, fz";
  found.value = rms;
  found.unit = "m/s^2";
  found.from = 0;
  found.to = inertial.t.back();
  found.text =
      fmt::format("|f| vibrates most at {} Hz, with {} m/s^2 rms{}", figure(frequency), figure(rms),
                  rest.seconds > 0 ? fmt::format(" (noise at rest {} m/s^2)", figure(rest.sigma_f.norm())) : "");
  found.evidence = "mean periodogram above 2 Hz over the whole record";
  findings.push_back(std::move(found));
}

}  // namespace binnacle::inspect
