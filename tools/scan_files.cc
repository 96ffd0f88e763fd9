#include "tools/scan_files.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>

#include "planegraph/base/error.h"

namespace planegraph::tools {
namespace {

namespace fs = std::filesystem;

bool IsCloud(const fs::path& path, const std::string& format) {
  const std::string ending = path.extension().string();
  if (format == "3dtk") return ending == ".3d";
  for (const char* known : {".ply", ".pcd", ".xyz", ".3d"}) {
    if (ending == known) return true;
  }
  return false;
}

std::vector<std::string> FilesOfFolder(const std::string& folder, const std::string& format) {
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (IsCloud(entry.path(), format)) files.push_back(entry.path().string());
  }
  if (error) throw InputError::InFile(folder, "cannot be listed: " + error.message());
  return files;
}

std::vector<std::string> FilesOfGlob(const std::string& pattern) {
  glob_t found{};
  std::vector<std::string> files;
  if (::glob(pattern.c_str(), 0, nullptr, &found) == 0) {
    files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  }
  ::globfree(&found);
  return files;
}

}  // namespace

std::vector<std::string> ScanFiles(const std::string& glob_or_folder, const std::string& format) {
  std::error_code error;
  const bool folder = fs::is_directory(glob_or_folder, error);
  auto files = folder ? FilesOfFolder(glob_or_folder, format) : FilesOfGlob(glob_or_folder);
  if (files.empty()) throw InputError::InFile(glob_or_folder, "no scan matches");
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace planegraph::tools
