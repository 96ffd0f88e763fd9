#include "layering/layers.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <regex>
#include <stdexcept>

namespace planegraph::layering {
namespace {

namespace fs = std::filesystem;

// Libraries that no header of ours may show to its users.
const std::regex kHiddenLibrary(
    "(nlohmann|yaml-cpp|pcl|embree[0-9]*|GeographicLib|libexif|glog|gflags)/.*|nanoflann\\.hpp");
// The rooms in which the solver's library is at home.
const std::set<std::string> kCeresRooms = {"graph", "factors", "solve"};
const std::set<std::string> kFactorsSee = {"base", "geometry", "graph", "factors"};

std::string ReadAll(const fs::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Where a file stands: its room is a module, or else a folder of the top level.
struct Place {
  std::string room;
  bool is_public = false;
};

Place PlaceOf(const fs::path& relative) {
  std::vector<std::string> parts;
  for (const auto& part : relative) parts.push_back(part.string());
  if (parts[0] == "include" && parts.size() > 2) return {parts[2], true};
  if (parts[0] == "src" && parts.size() > 1) return {parts[1], false};
  return {parts[0], false};
}

// The room that an include points to: of "planegraph/graph/graph.h", "graph/x.h" and "tools/x.h"
// the folder before the file's name.
std::string RoomOf(const std::string& include) {
  const std::string own = "planegraph/";
  const std::string path = include.rfind(own, 0) == 0 ? include.substr(own.size()) : include;
  return path.substr(0, path.find('/'));
}

std::string CheckModules(const Layers& layers, const Place& place, const std::string& target) {
  if (place.room == "factors" && layers.count(target) && !kFactorsSee.count(target)) {
    return "factors see only base, geometry and graph, not " + target;
  }
  const auto module = layers.find(place.room);
  if (module == layers.end() || target == place.room || !layers.count(target)) return "";
  if (module->second.count(target)) return "";
  return target + " does not lie below " + place.room;
}

std::string CheckLibraries(const Layers& layers, const Place& place, const std::string& include) {
  const bool ours = layers.count(place.room) || place.room == "factors";
  if (ours && include.rfind("ceres/", 0) == 0 && !kCeresRooms.count(place.room)) {
    return "Ceres is for graph, factors and solve alone";
  }
  if (place.is_public && std::regex_match(include, kHiddenLibrary)) {
    return "no public header shows " + include;
  }
  return "";
}

std::string Check(const Layers& layers, const Place& place, const std::string& include) {
  const std::string target = RoomOf(include);
  if (target == "tools" && place.room != "tools") return "nothing includes tools/";
  if (target == "factors" && place.room != "factors") return "nothing includes factors/";
  const std::string reason = CheckModules(layers, place, target);
  return reason.empty() ? CheckLibraries(layers, place, include) : reason;
}

void CheckFile(const Layers& layers, const fs::path& root, const fs::path& file,
               std::vector<std::string>* violations) {
  static const std::regex kInclude(R"re(^\s*#\s*include\s*["<]([^">]+)[">].*)re");
  const fs::path relative = file.lexically_relative(root);
  std::ifstream stream(file);
  std::smatch match;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (!std::regex_match(line, match, kInclude)) continue;
    const std::string reason = Check(layers, PlaceOf(relative), match[1]);
    if (reason.empty()) continue;
    violations->push_back(relative.string() + ":" + std::to_string(number) + ": " + reason);
  }
}

std::vector<fs::path> SourceFiles(const fs::path& root) {
  std::vector<fs::path> files;
  for (const char* folder : {"include", "src", "factors", "tools", "benchmarks", "tests"}) {
    if (!fs::exists(root / folder)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string suffix = entry.path().extension().string();
      if (suffix == ".h" || suffix == ".cc") files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

Layers ParseLayers(const std::string& cmake_lists) {
  static const std::regex kModule(R"(planegraph_add_module\(\s*(\w+)([^)]*)\))");
  static const std::regex kDependency(R"(planegraph_(\w+))");
  Layers layers;
  for (std::sregex_iterator it(cmake_lists.begin(), cmake_lists.end(), kModule), end; it != end;
       ++it) {
    const std::string name = (*it)[1], depends = (*it)[2];
    std::set<std::string> below;
    for (std::sregex_iterator dep(depends.begin(), depends.end(), kDependency); dep != end; ++dep) {
      if ((*dep)[1] == "factors") continue;  // beside the modules: its files see no more than graph
      const auto lower = layers.find((*dep)[1]);
      if (lower == layers.end()) throw std::runtime_error(name + " depends upwards");
      below.insert(lower->first);
      below.insert(lower->second.begin(), lower->second.end());
    }
    layers[name] = below;
  }
  return layers;
}

std::vector<std::string> FindViolations(const fs::path& root) {
  const Layers layers = ParseLayers(ReadAll(root / "src" / "CMakeLists.txt"));
  std::vector<std::string> violations;
  for (const auto& file : SourceFiles(root)) CheckFile(layers, root, file, &violations);
  return violations;
}

}  // namespace planegraph::layering
