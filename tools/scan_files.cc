#include "tools/scan_files.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>

#include "planegraph/base/error.h"
#include "planegraph/pipeline/site.h"

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

bool IsSite(const fs::path& path) {
  return path.extension() == ".yaml" || path.extension() == ".yml";
}

ScanList ScansOfSite(const std::string& path, const std::string& format) {
  const Site site = ReadSite(path);
  if (site.robots.size() > 1) {
    throw UsageError("--scans: the site " + path +
                     " has several robots: name the scans of one by a glob");
  }
  const RobotSite& robot = site.robots.front();
  return {robot.scans, format == "auto" ? robot.format : format};
}

}  // namespace

ScanList FindScans(const std::string& glob_folder_or_site, const std::string& format) {
  if (IsSite(glob_folder_or_site)) return ScansOfSite(glob_folder_or_site, format);
  std::error_code error;
  const bool folder = fs::is_directory(glob_folder_or_site, error);
  auto files =
      folder ? FilesOfFolder(glob_folder_or_site, format) : FilesOfGlob(glob_folder_or_site);
  if (files.empty()) throw InputError::InFile(glob_folder_or_site, "no scan matches");
  std::sort(files.begin(), files.end());
  return {files, format};
}

}  // namespace planegraph::tools
