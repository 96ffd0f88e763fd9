#include "sweep/fingerprint.h"

#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <vector>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/pipeline/site.h"

namespace planegraph {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> FilesBelow(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (auto it = fs::recursive_directory_iterator(folder, error); !error && it != fs::end(it);
       it.increment(error)) {
    if (it->is_regular_file()) files.push_back(it->path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

void AddTrajectory(const Trajectory& trajectory, Fingerprint* print) {
  for (std::size_t k = 0; k < trajectory.size(); ++k) {
    const Rigid3& pose = trajectory.poses[k];
    print->Add(trajectory.times[k]);
    for (int i = 0; i < 3; ++i) print->Add(pose.translation[i]);
    for (int i = 0; i < 4; ++i) print->Add(pose.rotation.coeffs()[i]);
  }
}

void AddSite(const Site& site, const std::string& base, Fingerprint* print) {
  for (const RobotSite& robot : site.robots) {
    for (const std::string& scan : robot.scans) print->AddFile(scan, base);
    if (robot.odometry) AddTrajectory(*robot.odometry, print);
    if (!robot.reference.empty()) print->AddFile(robot.reference, base);
    if (robot.gps) print->AddFile(robot.gps->file, base);
  }
  for (const DroneMapSite& map : site.maps) {
    for (const std::string& file :
         {map.cloud, map.cameras, map.gps, map.image_times, map.reference}) {
      if (!file.empty()) print->AddFile(file, base);
    }
  }
}

}  // namespace

void Fingerprint::Bytes(std::string_view bytes) {
  for (const char c : bytes) {
    hash_ ^= static_cast<unsigned char>(c);
    hash_ *= 1099511628211u;
  }
}

Fingerprint& Fingerprint::Add(std::string_view text) {
  Bytes(std::to_string(text.size()) + ":");
  Bytes(text);
  return *this;
}

Fingerprint& Fingerprint::Add(double value) {
  char bytes[sizeof(value)];
  std::memcpy(bytes, &value, sizeof(value));
  Bytes({bytes, sizeof(bytes)});
  return *this;
}

Fingerprint& Fingerprint::AddFile(const std::string& path, const std::string& base) {
  if (fs::is_directory(path)) {
    for (const std::string& file : FilesBelow(path)) AddFile(file, base);
    return *this;
  }
  struct stat status {};
  const bool found = ::stat(path.c_str(), &status) == 0;
  Add(fs::path(path).lexically_relative(base).string());
  if (!found) return Add("absent");
  return Add(std::to_string(status.st_size) + " " + std::to_string(status.st_mtim.tv_sec) + "." +
             std::to_string(status.st_mtim.tv_nsec));
}

std::string Fingerprint::Hex() const {
  char text[17] = "0000000000000000";
  char digits[16];
  const auto end = std::to_chars(digits, digits + 16, hash_, 16).ptr;
  std::copy(digits, end, text + 16 - (end - digits));
  return text;
}

std::string SiteFingerprint(const std::string& site) {
  Fingerprint print;
  try {
    print.Add(ReadTextFile(site));
    AddSite(ReadSite(site), fs::path(site).parent_path().string(), &print);
  } catch (const InputError& error) {
    print.Add(error.what());  // the run will say so, too
  }
  return print.Hex();
}

}  // namespace planegraph
