// MVE's bundle and Bundler v0.3 (Snavely's README): the same layout, other axes of the camera and
// other lists of views.
#include <array>

#include "io/camera_formats.h"
#include "io/number_stream.h"
#include "io/trajectory_formats.h"
#include "planegraph/base/atomic_file.h"

namespace planegraph {
namespace {

constexpr char kMveHeader[] = "drews 1.0", kBundlerHeader[] = "# Bundle file";
constexpr std::size_t kNumbersPerCamera = 15, kLeastNumbersPerPoint = 7;

std::string_view FirstLine(std::string_view bytes) {
  std::string_view line;
  LineReader(bytes).Next(&line);
  return Trim(line);
}

// Bundler's camera frame is x right, y up, z backward.
Rigid3 TurnedForward(const Rigid3& camera_from_model) {
  static const Eigen::Quaterniond kHalfTurnAboutX(0.0, 1.0, 0.0, 0.0);
  return Rigid3(kHalfTurnAboutX, Eigen::Vector3d::Zero()) * camera_from_model;
}

Camera ParseCamera(NumberStream* numbers, bool bundler, const std::string& file) {
  std::array<double, kNumbersPerCamera> v{};
  const std::size_t line = numbers->line() + 1;
  for (double& value : v) value = numbers->Number();
  Camera camera;
  camera.focal = v[0];
  if (camera.focal < 0.0) throw InputError::AtLine(file, line, "the focal length is negative");
  camera.valid = camera.focal > 0.0;
  if (!camera.valid) return camera;
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> rotation(&v[3]);
  const Eigen::Vector3d translation(v[12], v[13], v[14]);
  const Rigid3 pose(CheckedRotation(rotation, file, line + 1), translation);
  camera.camera_from_model = bundler ? TurnedForward(pose) : pose;
  return camera;
}

// Position, colour, and the views: camera, key, x, y in Bundler; camera, key, error in MVE.
Eigen::Vector3d ParsePoint(NumberStream* numbers, bool bundler) {
  Eigen::Vector3d point;
  for (double& value : point) value = numbers->Number();
  numbers->Skip(3);
  const std::size_t numbers_per_view = bundler ? 4 : 3;
  numbers->Skip(numbers_per_view * numbers->Count(numbers_per_view, "views"));
  return point;
}

void AppendRow(std::string* text, const Eigen::Vector3d& row) {
  for (int axis = 0; axis < 3; ++axis) {
    if (axis > 0) *text += ' ';
    AppendNumber(text, row[axis]);
  }
  *text += '\n';
}

void AppendCamera(std::string* text, const Camera& camera) {
  const double focal = camera.focal > 0.0 ? camera.focal : 1.0;
  if (!camera.valid) {
    for (int row = 0; row < 5; ++row) *text += "0 0 0\n";
    return;
  }
  const Eigen::Matrix3d rotation = camera.camera_from_model.rotation.toRotationMatrix();
  AppendRow(text, Eigen::Vector3d(focal, 0.0, 0.0));
  for (int i = 0; i < 3; ++i) AppendRow(text, rotation.row(i).transpose());
  AppendRow(text, camera.camera_from_model.translation);
}

}  // namespace

bool LooksLikeBundle(std::string_view bytes) {
  const std::string_view first = FirstLine(bytes);
  return first == kMveHeader || first.starts_with(kBundlerHeader);
}

CameraModel ParseBundle(std::string_view bytes, const std::string& file) {
  const std::string_view first = FirstLine(bytes);
  const bool bundler = first.starts_with(kBundlerHeader);
  if (bundler && !first.ends_with("v0.3")) {
    throw InputError::AtLine(file, 1, "is a Bundler file, but not of version 0.3");
  }
  if (!bundler && first != kMveHeader) {
    throw InputError::AtLine(file, 1,
                             "holds no cameras in a known format (MVE, Bundler, COLMAP, OpenSfM)");
  }
  LineReader lines(bytes);
  std::string_view line;
  lines.Next(&line);
  NumberStream numbers(bytes.substr(lines.position()), file, 2);
  CameraModel model;
  model.format = bundler ? "bundler" : "mve";
  const std::size_t camera_count = numbers.Count(kNumbersPerCamera, "cameras");
  const std::size_t point_count = numbers.Count(kLeastNumbersPerPoint, "points");
  model.cameras.reserve(camera_count);
  model.points.reserve(point_count);
  for (std::size_t i = 0; i < camera_count; ++i) {
    model.cameras.push_back(ParseCamera(&numbers, bundler, file));
  }
  for (std::size_t i = 0; i < point_count; ++i) {
    model.points.push_back(ParsePoint(&numbers, bundler));
  }
  return model;
}

void WriteMveCameras(const std::string& path, const CameraModel& model) {
  std::string text = std::string(kMveHeader) + "\n" + std::to_string(model.cameras.size()) + " " +
                     std::to_string(model.points.size()) + "\n";
  for (const Camera& camera : model.cameras) AppendCamera(&text, camera);
  for (const Eigen::Vector3d& point : model.points) {
    AppendRow(&text, point);
    text += "255 255 255\n0\n";
  }
  WriteTextFile(path, text);
}

}  // namespace planegraph
