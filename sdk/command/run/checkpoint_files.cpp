// SPDX-License-Identifier: Apache-2.0
#include "checkpoint_files.hpp"

#include <fstream>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "atomic_file.hpp"
#include "binnacle/unit.hpp"
#include "output.hpp"
#include "wording/special_file.hpp"

namespace binnacle::command {

namespace {

namespace fs = std::filesystem;

Time time_of(std::string_view text) {
  const auto quantity = parse_quantity(text);
  const auto refuse = [&](const std::string& why) {
    throw UsageError(fmt::format("--checkpoint FILE@TIME: '{}' is not a time between checkpoints: {}", text, why));
  };
  if (!quantity) refuse(quantity.error());
  if (quantity->dimension.is_dimensionless()) refuse(fmt::format("the unit is missing; is {}s meant?", text));
  if (!(quantity->dimension == parse_unit("s")->dimension)) refuse(dimension_name(quantity->dimension));
  if (!(quantity->value >= 1e-9)) refuse("it is not above 0");
  return nanoseconds(quantity->value);
}

}  // namespace

void CheckpointFiles::add_to(CLI::App& app) {
  app.add_option("--checkpoint", text_, "Write a checkpoint of the run to FILE every 60 s of its time, or every TIME")
      ->type_name("FILE[@60s]");
  app.add_option("--resume", resume_text_, "Continue from a checkpoint")->type_name("FILE");
}

void CheckpointFiles::open() {
  const auto at = text_.rfind('@');
  keep_ = text_.substr(0, at);
  if (at != std::string::npos) every_ = time_of(std::string_view(text_).substr(at + 1));
  if (!text_.empty() && keep_.empty()) throw UsageError("--checkpoint FILE@TIME: the file's name is missing");
  resume_ = resume_text_;
  if (!keep_.empty()) AtomicFile(fs::path(keep_));  // a bad name is reported at once
  if (resume_.empty()) return;
  if (wording::is_special_file(resume_))
    throw UsageError(fmt::format("--resume: '{}' is not a regular file", resume_.string()));
  std::ifstream file(resume_, std::ios::binary);
  if (!file) throw UsageError(fmt::format("--resume: there is no checkpoint '{}'", resume_.string()));
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const auto* data = reinterpret_cast<const std::byte*>(bytes.data());
  from_.assign(data, data + bytes.size());
  if (from_.empty()) from_.resize(1);  // torn, not none
}

Checkpoints CheckpointFiles::checkpoints() { return {every_, keep_.empty() ? nullptr : this, from_}; }

void CheckpointFiles::keep(std::span<const std::byte> checkpoint) {
  AtomicFile file(keep_);
  file.write({reinterpret_cast<const char*>(checkpoint.data()), checkpoint.size()});
  file.commit();
}

std::string CheckpointFiles::advice() const {
  const fs::path& last = keep_.empty() ? resume_ : keep_;
  return last.empty() ? "" : fmt::format("; continue with --resume {}", last.string());
}

void CheckpointFiles::remove() const {
  std::error_code ignored;
  for (const fs::path& file : {keep_, kept_records(), resume_, resumed_records()})
    if (!file.empty()) fs::remove(file, ignored);
}

fs::path CheckpointFiles::records_of(const fs::path& file) {
  return file.empty() ? fs::path() : fs::path(file.string() + ".records");
}

}  // namespace binnacle::command
