// SPDX-License-Identifier: Apache-2.0
// Variants of a config by name: what a run of one of them needs of "study".
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "binnacle/composition.hpp"
#include "binnacle/config.hpp"

namespace binnacle::study {

/// A name and the merge patches of the config that make it, as LoadOptions::patches takes them.
struct VariantPatches {
  std::string name;
  std::vector<std::string> patches;
};

/// Those of "study": first one of each of "dimensions" ("lc low": the first dimension turns slowest), then "variants".
/// If there is neither: "base", without a patch.
std::vector<VariantPatches> variants_of(const Config& config, Diagnostics& diagnostics);

/// The patches of the variant. Throws ConfigError (B090) where there is none of that name.
std::vector<std::string> patches_of(const std::filesystem::path& config, const LoadOptions& options,
                                    const std::string& variant);

/// Errors (B027) of the variant's metrics under "evaluate" that none of `variants` which list them can make; `options`
/// are those that the variant was loaded with.
Diagnostics misspelt_metrics(const Composition& variant,
                             const std::vector<std::shared_ptr<const Composition>>& variants,
                             const std::filesystem::path& path, const LoadOptions& options);
/// The same against all variants of the study in the config at `path`. Throws ConfigError.
void refuse_misspelt_metrics(const Composition& variant, const std::filesystem::path& path, const LoadOptions& options);

}  // namespace binnacle::study
