#include "planegraph/pipeline/site.h"

#include <glob.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <set>

#include "pipeline/true_scale.h"
#include "pipeline/yaml_reader.h"
#include "planegraph/base/angles.h"
#include "planegraph/base/error.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/gps_io.h"

namespace planegraph {
namespace {

namespace fs = std::filesystem;

class SiteReader : private YamlReader {
 public:
  using YamlReader::YamlReader;

  Site Read();

 private:
  std::vector<double> Numbers(const YAML::Node& node, std::size_t count,
                              const std::string& what) const;
  std::vector<std::string> Scans(const YAML::Node& robot, const std::string& format) const;
  std::vector<std::string> FilesInFolder(const fs::path& folder, const std::string& format) const;
  std::optional<Trajectory> Odometry(const YAML::Node& robot, const RobotSite& site) const;
  StartPose Start(const YAML::Node& node) const;
  std::string Format(const YAML::Node& robot) const;
  void CheckFilter(const YAML::Node& node, const FilterStep& step) const;
  std::vector<FilterStep> Filters(const YAML::Node& node) const;
  RobotSite Robot(const YAML::Node& node) const;
  DroneMapSite Map(const YAML::Node& node) const;
  RobotGps Gps(const YAML::Node& robot, const RobotSite& site) const;
  std::optional<GravityPrior> Gravity(const YAML::Node& node) const;
  OdometryNoise Noise(const YAML::Node& node) const;
  std::optional<double> Positive(const YAML::Node& map, const std::string& key) const;
  MapTiling Tiles(const YAML::Node& node) const;
  GeodeticPosition Origin(const YAML::Node& node) const;
};

std::vector<double> SiteReader::Numbers(const YAML::Node& node, std::size_t count,
                                        const std::string& what) const {
  auto values = Value<std::vector<double>>(node, what);
  if (values.size() != count) {
    Fail(node, what + " needs " + std::to_string(count) + " numbers");
  }
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::all_of(values.begin(), values.end(), finite)) Fail(node, what + " is not finite");
  return values;
}

std::vector<std::string> SiteReader::FilesInFolder(const fs::path& folder,
                                                   const std::string& format) const {
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string own = CloudFormatOfEnding(entry.path().string());
    const bool wanted = format == "3dtk" ? own == "3dtk" : !own.empty();
    if (entry.is_regular_file() && wanted) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> SiteReader::Scans(const YAML::Node& robot,
                                           const std::string& format) const {
  if (!robot["scans"]) Fail(robot, "a robot needs `scans`: a glob or a folder");
  const fs::path pattern = folder_ / Value<std::string>(robot["scans"], "scans");
  std::vector<std::string> files;
  if (fs::is_directory(pattern)) {
    files = FilesInFolder(pattern, format);
  } else {
    glob_t matches;
    if (::glob(pattern.c_str(), 0, nullptr, &matches) == 0) {
      files.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
    }
    ::globfree(&matches);
  }
  if (files.empty() && fs::is_directory(pattern)) {
    Fail(robot["scans"], "the folder " + pattern.string() + " holds no scans (" + CloudEndings() +
                             "); export .las, .e57 and others first: docs/your_data.md");
  }
  if (files.empty()) Fail(robot["scans"], "no scan matches " + pattern.string());
  return files;
}

std::optional<Trajectory> SiteReader::Odometry(const YAML::Node& robot,
                                               const RobotSite& site) const {
  std::optional<Trajectory> odometry;
  if (!site.odometry_file.empty()) {
    odometry = ReadTrajectory(site.odometry_file);
  } else if (fs::exists(fs::path(site.scans.front()).replace_extension(".pose"))) {
    // 3DTK keeps a scan's odometry beside it.
    odometry.emplace();
    odometry->has_times = false;
    for (const auto& scan : site.scans) {
      odometry->times.push_back(static_cast<double>(odometry->times.size()));
      odometry->poses.push_back(Read3dtkPose(fs::path(scan).replace_extension(".pose").string()));
    }
  }
  if (odometry && odometry->size() != site.scans.size()) {
    Fail(robot["odometry"], "the odometry has " + std::to_string(odometry->size()) +
                                " poses, but there are " + std::to_string(site.scans.size()) +
                                " scans: line k belongs to scan k");
  }
  return odometry;
}

std::string SiteReader::Format(const YAML::Node& robot) const {
  static const std::set<std::string> kFormats = {"auto", "3dtk", "ply", "pcd", "xyz"};
  std::string format = Text(robot, "format", "auto");
  if (!kFormats.count(format)) {
    Fail(robot["format"], "unknown format '" + format + "' (auto, 3dtk, ply, pcd, xyz)");
  }
  return format;
}

StartPose SiteReader::Start(const YAML::Node& node) const {
  AllowKeys(node, {"translation", "rotation", "sigma_translation", "sigma_rotation_deg"});
  StartPose start;
  if (node["translation"]) {
    const auto t = Numbers(node["translation"], 3, "translation");
    start.world_from_scan.translation = {t[0], t[1], t[2]};
  }
  if (node["rotation"]) {
    const auto q = Numbers(node["rotation"], 4, "rotation");
    const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
    if (std::abs(rotation.norm() - 1.0) > 1e-2) {
      Fail(node["rotation"], "rotation is not a unit quaternion x y z w");
    }
    start.world_from_scan.rotation = rotation.normalized();
  }
  if (node["sigma_translation"]) {
    start.sigma_translation = Value<double>(node["sigma_translation"], "sigma_translation");
  }
  if (node["sigma_rotation_deg"]) {
    start.sigma_rotation =
        Value<double>(node["sigma_rotation_deg"], "sigma_rotation_deg") * std::numbers::pi / 180.0;
  }
  if (!(start.sigma_translation > 0) || !(start.sigma_rotation > 0)) {
    Fail(node, "standard deviations must be positive");
  }
  return start;
}

void SiteReader::CheckFilter(const YAML::Node& node, const FilterStep& step) const {
  try {
    FilterChain({step});
  } catch (const UsageError& error) {
    Fail(node, error.what());
  }
}

std::vector<FilterStep> SiteReader::Filters(const YAML::Node& node) const {
  if (!node.IsSequence()) Fail(node, "filters is a list, for example [{range: {min: 0.5}}]");
  std::vector<FilterStep> steps;
  for (const auto& item : node) {
    if (!item.IsMap() || item.size() != 1) Fail(item, "a filter is one `name: {parameters}`");
    FilterStep step{item.begin()->first.as<std::string>(), {}};
    const YAML::Node parameters = item.begin()->second;
    if (!parameters.IsMap() && !parameters.IsNull()) {
      Fail(item, step.name + " needs its parameters by name: {" + step.name + ": {key: value}}");
    }
    for (const auto& p : parameters) {
      step.parameters[p.first.as<std::string>()] =
          Value<double>(p.second, step.name + "." + p.first.as<std::string>());
    }
    CheckFilter(item, step);
    steps.push_back(std::move(step));
  }
  return steps;
}

// Positions belong to scans by the times of the odometry.
RobotGps SiteReader::Gps(const YAML::Node& robot, const RobotSite& site) const {
  RobotGps gps;
  gps.file = File(robot, "gps");
  if (!site.odometry || !site.odometry->has_times) {
    Fail(robot["gps"], "gps needs an odometry with time stamps");
  }
  if (ReadGps(gps.file).by_image) Fail(robot["gps"], "a robot's gps needs times, not images");
  if (robot["gps_lever"]) {
    const auto lever = Numbers(robot["gps_lever"], 3, "gps_lever");
    gps.lever = {lever[0], lever[1], lever[2]};
  }
  gps.sigma = Positive(robot, "gps_sigma").value_or(gps.sigma);
  return gps;
}

std::optional<GravityPrior> SiteReader::Gravity(const YAML::Node& node) const {
  if (!node) return std::nullopt;
  AllowKeys(node, {"up", "sigma_deg"});
  GravityPrior gravity;
  if (node["up"]) {
    const auto up = Numbers(node["up"], 3, "up");
    gravity.up = {up[0], up[1], up[2]};
    if (!(gravity.up.norm() > 1e-6)) Fail(node["up"], "up has no direction");
    gravity.up.normalize();
  }
  const auto degrees = Positive(node, "sigma_deg");
  if (degrees) gravity.sigma = *degrees * std::numbers::pi / 180.0;
  return gravity;
}

OdometryNoise SiteReader::Noise(const YAML::Node& node) const {
  OdometryNoise noise;
  const std::map<std::string, std::pair<double*, double>> fields = {
      {"step", {&noise.step, 1.0}},
      {"per_metre", {&noise.per_metre, 1.0}},
      {"scale", {&noise.scale, 1.0}},
      {"step_deg", {&noise.step_rotation, kDegree}},
      {"per_turn", {&noise.per_turn, 1.0}},
      {"per_metre_deg", {&noise.rotation_per_metre, kDegree}}};
  std::set<std::string> names;
  for (const auto& field : fields) names.insert(field.first);
  AllowKeys(node, names);
  for (const auto& [name, field] : fields) {
    if (!node[name]) continue;
    const auto value = Value<double>(node[name], name);
    const bool may_be_zero = name.rfind("step", 0) != 0;
    if (!(value > 0.0 || (may_be_zero && value == 0.0)) || !std::isfinite(value)) {
      Fail(node[name], name + " must be positive");
    }
    *field.first = value * field.second;
  }
  return noise;
}

RobotSite SiteReader::Robot(const YAML::Node& node) const {
  AllowKeys(node, {"name", "scans", "format", "odometry", "start", "reference", "filters", "gps",
                   "gps_lever", "gps_sigma", "gravity", "odometry_noise"});
  RobotSite robot;
  robot.name = Text(node, "name", "");
  if (robot.name.empty() || robot.name.find('/') != std::string::npos) {
    Fail(node, "a robot needs a `name` without a slash");
  }
  robot.format = Format(node);
  robot.scans = Scans(node, robot.format);
  robot.odometry_file = File(node, "odometry");
  robot.odometry = Odometry(node, robot);
  if (node["start"]) robot.start = Start(node["start"]);
  robot.reference = File(node, "reference");
  if (!robot.reference.empty()) ReadTrajectory(robot.reference);  // a bad one shows before the run
  if (node["filters"]) robot.filters = Filters(node["filters"]);
  if (node["gps"]) robot.gps = Gps(node, robot);
  robot.gravity = Gravity(node["gravity"]);
  if (node["odometry_noise"]) robot.odometry_noise = Noise(node["odometry_noise"]);
  return robot;
}

std::optional<double> SiteReader::Positive(const YAML::Node& map, const std::string& key) const {
  if (!map[key]) return std::nullopt;
  const auto value = Value<double>(map[key], key);
  if (!(value > 0.0) || !std::isfinite(value)) Fail(map[key], key + " must be positive");
  return value;
}

GeodeticPosition SiteReader::Origin(const YAML::Node& node) const {
  AllowKeys(node, {"lat", "lon", "alt"});
  for (const char* key : {"lat", "lon", "alt"}) {
    if (!node[key]) Fail(node, std::string("origin needs `") + key + "`");
  }
  const GeodeticPosition origin{Value<double>(node["lat"], "lat"),
                                Value<double>(node["lon"], "lon"),
                                Value<double>(node["alt"], "alt")};
  if (!IsOnEarth(origin)) Fail(node, "origin is no place on earth");
  return origin;
}

MapTiling SiteReader::Tiles(const YAML::Node& node) const {
  if (!node.IsMap()) Fail(node, "tiles needs its keys by name: {size: 30}");
  AllowKeys(node, {"size", "sigma_scale", "sigma_rotation_deg", "sigma_translation"});
  MapTiling tiles;
  tiles.size = Positive(node, "size").value_or(tiles.size);
  if (tiles.size < MapTiling::kLeastSize) Fail(node["size"], "size must be at least 1 m");
  tiles.sigma_scale = Positive(node, "sigma_scale").value_or(tiles.sigma_scale);
  const auto degrees = Positive(node, "sigma_rotation_deg");
  if (degrees) tiles.sigma_rotation = *degrees * std::numbers::pi / 180.0;
  tiles.sigma_translation = Positive(node, "sigma_translation").value_or(tiles.sigma_translation);
  return tiles;
}

DroneMapSite SiteReader::Map(const YAML::Node& node) const {
  AllowKeys(node, {"name", "cloud", "cameras", "gps", "image_times", "scale", "scale_sigma",
                   "gps_sigma", "gravity", "reference", "tiles"});
  DroneMapSite map{Text(node, "name", ""),     File(node, "cloud"),
                   File(node, "cameras"),      File(node, "gps"),
                   File(node, "image_times"),  Positive(node, "scale_sigma"),
                   Positive(node, "gps_sigma")};
  map.scale = Positive(node, "scale");
  map.gravity = Gravity(node["gravity"]);
  if (node["tiles"]) map.tiles = Tiles(node["tiles"]);
  map.reference = File(node, "reference");
  if (!map.reference.empty()) map.true_scale = ReadTrueScale(map.reference);
  if (map.name.empty()) Fail(node, "a map needs a `name`");
  if (map.cloud.empty()) Fail(node, "a map needs a `cloud`");
  return map;
}

// The marks of PLY, PCD and of any binary file.
bool LooksLikeCloud(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string start(64, ' ');
  stream.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream.gcount()));
  return start.rfind("ply\n", 0) == 0 || start.rfind("ply\r", 0) == 0 ||
         start.rfind("# .PCD", 0) == 0 || start.find('\0') != std::string::npos;
}

Site SiteReader::Read() {
  if (fs::is_directory(path_)) {
    throw InputError::InFile(path_,
                             "is a folder: `map` takes a site file that names it (robots: [{name: "
                             "cart, scans: FOLDER}]); see docs/your_data.md");
  }
  if (LooksLikeCloud(path_)) throw InputError::InFile(path_, "is a cloud, not a site file");
  const YAML::Node root = Load();
  if (!root.IsMap()) throw InputError::AtLine(path_, 1, "is not a site file");
  AllowKeys(root, {"name", "origin", "robots", "maps"});
  Site site;
  site.name = Text(root, "name", fs::path(path_).stem().string());
  if (root["origin"]) site.origin = Origin(root["origin"]);
  if (root["robots"] && root["robots"].IsMap()) {
    Fail(root["robots"], "`robots` is a list: each of them begins with `- name:`");
  }
  if (!root["robots"] || !root["robots"].IsSequence() || root["robots"].size() == 0) {
    Fail(root, "a site needs `robots`: a list with at least one");
  }
  std::set<std::string> names;
  for (const auto& node : root["robots"]) {
    site.robots.push_back(Robot(node));
    if (!names.insert(site.robots.back().name).second) Fail(node, "this robot's name is taken");
  }
  if (root["maps"]) {
    if (!root["maps"].IsSequence())
      Fail(root["maps"], "`maps` is a list: each of them begins with `- name:`");
    for (const auto& node : root["maps"]) site.maps.push_back(Map(node));
  }
  return site;
}

}  // namespace

Site ReadSite(const std::string& path) { return SiteReader(path).Read(); }

}  // namespace planegraph
