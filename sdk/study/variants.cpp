// SPDX-License-Identifier: Apache-2.0
// Names and merge patches of a study's variants.
#include <algorithm>

#include "score/sections.hpp"
#include "study/section.hpp"
#include "study/variants.hpp"
#include "wording/wording.hpp"

namespace binnacle::study {

using namespace wording;

namespace {

/// Every variant so far with every choice of the dimension behind it.
std::vector<VariantPatches> crossed(const std::vector<VariantPatches>& variants, const Json& choices,
                                    const std::string& pointer) {
  std::vector<VariantPatches> result;
  for (const auto& variant : variants)
    for (const auto& [name, patch] : choices.items()) {
      VariantPatches next = variant;
      next.name += (next.name.empty() || name.empty() ? "" : " ") + name;
      next.patches.push_back(join_pointer(pointer, name));
      result.push_back(std::move(next));
    }
  return result;
}

}  // namespace

std::vector<VariantPatches> variants_of(const Config& config, Diagnostics& diagnostics) {
  const Section section(config, diagnostics);
  std::vector<VariantPatches> variants;
  const auto are_patches = [&](const std::string& pointer, const Json& patches) {
    for (const auto& [name, patch] : patches.items()) {
      section.object(join_pointer(pointer, name));
      if (patch.is_object() && patch.contains("study"))
        section.key_error("B012", join_pointer(join_pointer(pointer, name), "study"),
                          "a variant changes what is run, not the study");
    }
  };
  if (!section.object("/study")) return {{"base", {}}};
  if (const Json* dimensions = section.object("/study/dimensions")) {
    if (!dimensions->empty()) variants = {{"", {}}};
    for (const auto& [name, choices] : dimensions->items()) {
      const std::string pointer = join_pointer("/study/dimensions", name);
      if (!section.object(pointer)) continue;
      are_patches(pointer, choices);
      variants = crossed(variants, choices, pointer);
    }
  }
  if (const Json* own = section.object("/study/variants")) {
    are_patches("/study/variants", *own);
    for (const auto& [name, patch] : own->items()) {
      const std::string pointer = join_pointer("/study/variants", name);
      const bool is_there = std::any_of(variants.begin(), variants.end(),
                                        [&, n = name](const VariantPatches& other) { return other.name == n; });
      if (is_there) section.key_error("B091", pointer, "the dimensions make a variant " + in_quotes(name) + " already");
      if (name.empty()) section.key_error("B091", pointer, "a variant has a name; \"\" is an empty cell of a table");
      variants.push_back({name, {pointer}});
    }
  }
  if (variants.empty()) return {{"base", {}}};
  return variants;
}

std::vector<std::string> patches_of(const std::filesystem::path& path, const LoadOptions& options,
                                    const std::string& name) {
  const Config config = score::load_config(path, options);
  Diagnostics diagnostics;
  const auto variants = variants_of(config, diagnostics);
  if (diagnostics.has_errors()) throw ConfigError(diagnostics);
  std::vector<std::string> names;
  for (const auto& variant : variants) {
    if (variant.name == name) return variant.patches;
    names.push_back(variant.name);
  }
  Section(config, diagnostics)
      .key_error("B090", "/study",
                 "there is no variant " + in_quotes(name) + suggestion(name, names) + " (variants: " + listed(names) +
                     ")");
  throw ConfigError(diagnostics);
}

}  // namespace binnacle::study
