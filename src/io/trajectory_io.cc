#include "planegraph/io/trajectory_io.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "io/file_bytes.h"
#include "io/g2o_parser.h"
#include "io/text_scanner.h"
#include "io/trajectory_formats.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr std::size_t kTumColumns = 8, kKittiColumns = 12;

std::vector<double> ParseRow(std::string_view line, const std::string& file, std::size_t number) {
  std::vector<double> row;
  const bool commas = line.find(',') != line.npos;
  for (const std::string_view field : SplitFields(line, commas ? ',' : ' ')) {
    double value = 0.0;
    if (!ParseNumber(field, &value) || !std::isfinite(value)) {
      throw InputError::AtLine(file, number, "is not a finite number: " + Excerpt(field));
    }
    row.push_back(value);
  }
  return row;
}

void AddTum(const std::vector<double>& row, const std::string& file, std::size_t line,
            Trajectory* trajectory) {
  constexpr double kNormTolerance = 1e-2;
  const Eigen::Quaterniond rotation(row[7], row[4], row[5], row[6]);
  const double norm = rotation.norm();
  if (!(std::abs(norm - 1.0) <= kNormTolerance)) {
    throw InputError::AtLine(file, line,
                             "the quaternion's norm is " + std::to_string(norm) + ", not 1");
  }
  trajectory->norm_error = std::max(trajectory->norm_error, std::abs(norm - 1.0));
  trajectory->times.push_back(row[0]);
  trajectory->poses.emplace_back(rotation.normalized(), Eigen::Vector3d(row[1], row[2], row[3]));
}

void AddKitti(const std::vector<double>& row, const std::string& file, std::size_t line,
              Trajectory* trajectory) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(row.data());
  trajectory->times.push_back(static_cast<double>(trajectory->size()));
  trajectory->poses.emplace_back(CheckedRotation(matrix.leftCols<3>(), file, line), matrix.col(3));
  trajectory->matrices.push_back(matrix.leftCols<3>());
}

std::vector<std::string> FilesEndingIn(const std::string& folder, const std::string& ending) {
  std::vector<std::string> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().extension() == ending) files.push_back(entry.path().string());
  }
  if (error) throw InputError::InFile(folder, "cannot be listed: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

// The first line that is neither empty nor a comment starts with a tag: capitals and an underscore.
bool LooksLikeG2o(std::string_view bytes) {
  LineReader lines(bytes);
  std::string_view line;
  while (lines.Next(&line)) {
    line = Trim(line);
    if (line.empty() || line.front() == '#') continue;
    const std::string_view tag = line.substr(0, line.find_first_of(" \t"));
    const bool capitals = tag.find_first_of("abcdefghijklmnopqrstuvwxyz,.") == tag.npos;
    return tag == "FIX" || (capitals && tag.find('_') != tag.npos);
  }
  return false;
}

Trajectory Read3dtkFolder(const std::string& folder) {
  auto files = FilesEndingIn(folder, ".frames");
  const bool frames = !files.empty();
  if (!frames) files = FilesEndingIn(folder, ".pose");
  if (files.empty()) throw InputError::InFile(folder, "holds no .frames and no .pose files");
  Trajectory trajectory;
  trajectory.has_times = false;
  for (const std::string& file : files) {
    trajectory.times.push_back(static_cast<double>(trajectory.size()));
    trajectory.poses.push_back(frames ? Read3dtkFrames(file) : Read3dtkPose(file));
  }
  return trajectory;
}

}  // namespace

Eigen::Quaterniond CheckedRotation(const Eigen::Matrix3d& matrix, const std::string& file,
                                   std::size_t line) {
  constexpr double kTolerance = 1e-2;
  const double largest = matrix.cwiseAbs().maxCoeff();
  if (largest < 1.0 + kTolerance) {
    const Eigen::Matrix3d rotation = ProjectToRotation(matrix);
    if ((rotation - matrix).cwiseAbs().maxCoeff() <= kTolerance) {
      return Eigen::Quaterniond(rotation).normalized();
    }
  }
  throw InputError::AtLine(file, line, "the 3x3 matrix is not a rotation");
}

Trajectory ParseTrajectory(std::string_view bytes, const std::string& file) {
  Trajectory trajectory;
  std::size_t columns = 0;
  LineReader lines(bytes);
  std::string_view line;
  while (lines.Next(&line)) {
    if (Trim(line).empty() || Trim(line).front() == '#') continue;
    const auto row = ParseRow(line, file, lines.number());
    if (columns == 0) columns = row.size();
    if (row.size() != columns || (columns != kTumColumns && columns != kKittiColumns)) {
      throw InputError::AtLine(file, lines.number(),
                               std::to_string(row.size()) + " columns: TUM has 8, KITTI 12");
    }
    (columns == kTumColumns ? AddTum : AddKitti)(row, file, lines.number(), &trajectory);
  }
  if (trajectory.size() == 0) throw InputError::InFile(file, "holds no poses");
  trajectory.has_times = columns == kTumColumns;
  return trajectory;
}

Trajectory ReadTrajectory(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) return Read3dtkFolder(path);
  const FileBytes file(path);
  if (LooksLikeG2o(file.view())) return TrajectoryOf(ParseG2o(file.view(), path));
  return ParseTrajectory(file.view(), path);
}

void WriteTum(const std::string& path, const Trajectory& trajectory) {
  std::string text;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const Rigid3& pose = trajectory.poses[i];
    AppendNumber(&text, trajectory.times[i]);
    for (int axis = 0; axis < 3; ++axis) AppendNumber(&(text += ' '), pose.translation[axis]);
    for (int axis = 0; axis < 4; ++axis) AppendNumber(&(text += ' '), pose.rotation.coeffs()[axis]);
    text += '\n';
  }
  WriteTextFile(path, text);
}

void WriteKitti(const std::string& path, const Trajectory& trajectory) {
  std::string text;
  for (const Rigid3& pose : trajectory.poses) {
    const Eigen::Matrix4d matrix = pose.Matrix();
    for (int i = 0; i < 12; ++i) {
      if (i > 0) text += ' ';
      AppendNumber(&text, matrix(i / 4, i % 4));
    }
    text += '\n';
  }
  WriteTextFile(path, text);
}

}  // namespace planegraph
