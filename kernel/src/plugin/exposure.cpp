// SPDX-License-Identifier: Apache-2.0
// Who may change a library, and whether it was built here.
#include <unistd.h>

#include <cstdio>
#include <fstream>

#define BOOST_DLL_USE_STD_FS
#include <boost/dll/runtime_symbol_info.hpp>

#include "plugin/library.hpp"

namespace binnacle::internal::plugin {

namespace fs = std::filesystem;

namespace {

/// Root, the user, and who could exchange this program itself.
bool is_trusted(uid_t owner) {
  static const uid_t of_program = [] {
    struct stat status {};
    std::error_code error;
    return ::stat(boost::dll::symbol_location(role_name, error).c_str(), &status) == 0 ? status.st_uid : 0;
  }();
  return owner == 0 || owner == ::geteuid() || owner == of_program;
}

/// Whether everybody may write it, or a group other than the owner's own, which has the owner's number.
bool is_open(const struct stat& status) {
  const bool is_own_group = status.st_gid == 0 || status.st_gid == status.st_uid;
  return (status.st_mode & S_IWOTH) != 0 || ((status.st_mode & S_IWGRP) != 0 && !is_own_group);
}

/// Why the file, or the folder, is not to be trusted, and the remedy; "" where it is.
std::string flaw(const std::string* folder, const struct stat& status, bool is_any_owner_right) {
  if (!is_open(status) && (is_any_owner_right || is_trusted(status.st_uid))) return "";
  const std::string it = folder ? "the plugin's folder '" + *folder + "'" : "the plugin file";
  if (is_open(status))
    return it + ((status.st_mode & S_IWOTH) != 0 ? " is world-writable, so it is not loaded; chmod o-w it"
                                                 : " may be written by a group, so it is not loaded; chmod g-w it");
  return it + " belongs to user " + std::to_string(status.st_uid) +
         ", who is neither root, nor you, nor the owner of this program, so it is not loaded; copy it, or chown it";
}

}  // namespace

std::string exposure(const OpenFile& file, const fs::path& path, FolderLook& look) {
  if (std::string text = flaw(nullptr, file.status, false); !text.empty()) return text;
  std::string at = path.parent_path().string();
  if (look.folder == at) return look.exposure;
  look = {at, ""};
  struct stat status {};
  for (bool is_own = true; look.exposure.empty() && !at.empty() && ::stat(at.c_str(), &status) == 0; is_own = false) {
    if ((status.st_mode & S_ISVTX) != 0) status.st_mode &= ~static_cast<mode_t>(S_IWGRP | S_IWOTH);
    look.exposure = flaw(&at, status, !is_own);
    at.resize(at.find_last_of('/') == std::string::npos ? 0 : at.find_last_of('/'));
  }
  return look.exposure;
}

bool is_built_here(const fs::path& path) {
  const OpenFile file(path);
  const struct stat& status = file.status;
  char now[64];
  std::snprintf(now, sizeof now, "%ju %jd.%09ld", std::uintmax_t{status.st_ino}, std::intmax_t{status.st_ctim.tv_sec},
                status.st_ctim.tv_nsec);
  std::ifstream note(path.string() + ".built");
  std::string then;
  return file.failure.empty() && std::getline(note, then) && then == now;
}

}  // namespace binnacle::internal::plugin
