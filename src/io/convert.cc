#include "planegraph/io/convert.h"

#include <array>
#include <cstdio>
#include <filesystem>

#include "io/file_bytes.h"
#include "io/text_scanner.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/io/g2o_io.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {
namespace {

enum class Kind { kCloud, kTrajectory, kEither, kUnknown };

std::string EndingOf(const std::string& path) {
  return ToLower(std::filesystem::path(path).extension().string());
}

bool IsFolderName(const std::string& path) {
  const std::string ending = EndingOf(path);
  return path.back() == '/' || ending.empty() || ending == ".frames" ||
         std::filesystem::is_directory(path);
}

Kind KindOfEnding(const std::string& path) {
  const std::string ending = EndingOf(path);
  for (const char* cloud : {".ply", ".pcd", ".xyz", ".3d", ".pts", ".asc"}) {
    if (ending == cloud) return Kind::kCloud;
  }
  for (const char* trajectory : {".tum", ".kitti", ".g2o"}) {
    if (ending == trajectory) return Kind::kTrajectory;
  }
  return ending == ".txt" || ending == ".csv" ? Kind::kEither : Kind::kUnknown;
}

// A text file of 8 or 12 columns without names is a trajectory.
Kind KindOfContent(const std::string& path) {
  const FileBytes file(path);
  LineReader lines(file.view());
  std::string_view line;
  while (lines.Next(&line)) {
    line = Trim(line);
    if (line.empty() || line.front() == '#') continue;
    const auto fields = SplitFields(line, SeparatorOf(line));
    double number = 0.0;
    const bool pose = fields.size() == 8 || fields.size() == 12;
    return pose && ParseNumber(fields[0], &number) ? Kind::kTrajectory : Kind::kCloud;
  }
  return Kind::kCloud;
}

Kind KindOfInput(const std::string& path) {
  if (std::filesystem::is_directory(path)) return Kind::kTrajectory;
  const Kind kind = KindOfEnding(path);
  return kind == Kind::kEither || kind == Kind::kUnknown ? KindOfContent(path) : kind;
}

Kind KindOfOutput(const std::string& input, const std::string& output) {
  if (IsFolderName(output)) return Kind::kTrajectory;
  const Kind kind = KindOfEnding(output);
  if (kind == Kind::kEither) return KindOfInput(input);
  if (kind == Kind::kUnknown)
    throw InputError::InFile(output, "has no ending that says its format");
  const Kind given = KindOfEnding(input);  // .txt may hold either: then the output decides
  if ((given == Kind::kCloud || given == Kind::kTrajectory) && given != kind) {
    throw InputError::InFile(output, "a cloud does not become a trajectory, nor the reverse");
  }
  return kind;
}

void WriteFramesFolder(const std::string& folder, const Trajectory& trajectory) {
  CreateFolder(folder);
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    std::array<char, 40> name{};
    std::snprintf(name.data(), name.size(), "scan%03zu.frames", i);
    Write3dtkFrames((std::filesystem::path(folder) / name.data()).string(), trajectory.poses[i]);
  }
}

void WriteVertices(const std::string& path, const Trajectory& trajectory) {
  G2oGraph graph;
  for (const Rigid3& pose : trajectory.poses) {
    graph.vertices3.push_back({static_cast<long long>(graph.vertices3.size()), pose});
  }
  WriteG2o(path, graph);
}

bool WritesTum(const std::string& path) {
  const std::string ending = EndingOf(path);
  return !IsFolderName(path) && ending != ".kitti" && ending != ".g2o";
}

void SetTimes(const std::string& input, const std::string& stamps, Trajectory* trajectory) {
  if (trajectory->has_times) throw InputError::InFile(input, "has time stamps of its own");
  trajectory->times = ReadTimeStamps(stamps);
  trajectory->has_times = true;
  if (trajectory->times.size() == trajectory->poses.size()) return;
  throw InputError::InFile(stamps, "has " + std::to_string(trajectory->times.size()) +
                                       " time stamps for " +
                                       std::to_string(trajectory->poses.size()) + " poses");
}

void WriteTrajectory(const std::string& path, const Trajectory& trajectory) {
  const std::string ending = EndingOf(path);
  if (IsFolderName(path)) {
    WriteFramesFolder(path, trajectory);
  } else if (ending == ".kitti") {
    WriteKitti(path, trajectory);
  } else if (ending == ".g2o") {
    WriteVertices(path, trajectory);
  } else {
    WriteTum(path, trajectory);
  }
}

// Only TUM files hold quaternions, and only they have times.
void CheckQuaternions(const FileConventions& conventions, bool has_quaternions) {
  if (conventions.w_first && !has_quaternions) {
    throw UsageError("quaternions with w first (--quaternions=wxyz) are for TUM files");
  }
}

void CheckForCloud(const FileConventions& conventions) {
  CheckQuaternions(conventions, false);
  if (conventions.body_from_world) {
    throw UsageError("poses are inverted (--inverse) in trajectories alone");
  }
}

void CheckForGraph(const FileConventions& conventions) {
  CheckForCloud(conventions);
  if (conventions.scale != 1.0 || !conventions.axes.isIdentity(0.0)) {
    throw UsageError("graphs (g2o to g2o) take no --scale and no --axes");
  }
}

}  // namespace

Conversion ConvertFile(const std::string& input, const std::string& output,
                       const ConvertOptions& options) {
  if (output.empty()) throw InputError::InFile(output, "an output without a name");
  const bool cloud = KindOfOutput(input, output) == Kind::kCloud;
  if (!options.stamps.empty() && (cloud || !WritesTum(output))) {
    throw UsageError("time stamps (--stamps) are for trajectories written as TUM");
  }
  if (EndingOf(input) == ".g2o" && EndingOf(output) == ".g2o") {
    CheckForGraph(options.conventions);
    const G2oGraph graph = ReadG2o(input);
    WriteG2o(output, graph);
    return {"graph", graph.vertices3.size() + graph.vertices2.size()};
  }
  if (cloud) {
    CheckForCloud(options.conventions);
    const Cloud points = Interpret(options.conventions, ReadCloud(input));
    WriteCloud(output, points);
    return {"cloud", points.size()};
  }
  Trajectory trajectory = ReadTrajectory(input);
  CheckQuaternions(options.conventions, trajectory.has_times);
  trajectory = Interpret(options.conventions, trajectory);
  if (!options.stamps.empty()) SetTimes(input, options.stamps, &trajectory);
  WriteTrajectory(output, trajectory);
  return {"trajectory", trajectory.size()};
}

}  // namespace planegraph
