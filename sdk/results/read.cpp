// SPDX-License-Identifier: Apache-2.0
#include <fstream>
#include <iterator>
#include <new>

#include "read_files.hpp"
#include "results/results.hpp"
#include "wording/special_file.hpp"

namespace binnacle::results {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, const std::string& what, const char* verb) {
  throw std::runtime_error("'" + path.string() + "' cannot be read: " + what + "; make it again with 'binnacle " +
                           verb + " CONFIG --out " + path.parent_path().string() + "'");
}

void require_regular(const fs::path& path, const char* verb) {
  if (wording::is_special_file(path)) fail(path, "it is not a regular file", verb);
}

/// The JSON that is put in place last: without it the folder is not whole.
Json read_json(const fs::path& path, const char* verb) {
  require_regular(path, verb);
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "it is missing, so the others may be incomplete", verb);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded() || !json.is_object()) fail(path, "it is not a JSON object", verb);
  return json;
}

template <class Read>
auto read_netcdf(const fs::path& path, const char* verb, const Read& read) {
  require_regular(path, verb);
  try {
    return read(nc::File::open(path));
  } catch (const nc::LibraryMissing& missing) {
    throw std::runtime_error("'" + path.string() + "' cannot be read: " + missing.what());
  } catch (const nc::Failure& failure) {
    const std::string said = failure.what();
    fail(path, said.starts_with("NetCDF: ") ? "it is damaged, or no NetCDF file (" + said + ")" : said, verb);
  } catch (const nlohmann::json::exception&) {
    fail(path, "its provenance is damaged", verb);
  } catch (const std::bad_alloc&) {
    fail(path, "it declares more values than fit into memory", verb);
  } catch (const std::length_error&) {
    fail(path, "it declares more values than fit into memory", verb);
  }
}

}  // namespace

std::optional<StudyResults> read_study(const fs::path& folder) {
  const fs::path study = folder / "study.nc";
  std::error_code ignored;
  if (!fs::exists(study, ignored)) return std::nullopt;
  auto results = read_netcdf(study, "study", [](const nc::File& file) { return read_study(file); });
  results.figures = read_json(folder / "study.json", "study");
  return results;
}

Results read(const fs::path& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored)) throw std::runtime_error("'" + folder.string() + "' is not a folder");
  const fs::path run = folder / "run.nc";
  Results results;
  if (fs::exists(run, ignored)) {
    results.run = read_netcdf(run, "run", read_run);
    results.run->summary = read_json(folder / "summary.json", "run");
  }
  results.study = read_study(folder);
  if (!results.run && !results.study)
    throw std::runtime_error("'" + folder.string() +
                             "' holds neither run.nc nor study.nc; make one with 'binnacle run "
                             "CONFIG --out " +
                             folder.string() + "' or 'binnacle study CONFIG --out " + folder.string() + "'");
  return results;
}

}  // namespace binnacle::results
