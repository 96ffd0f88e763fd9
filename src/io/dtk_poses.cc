// 3DTK's .frames and .pose files. Their world is left-handed (x right, y up, z forward) in
// centimetres; ours is right-handed (x forward, y left, z up) in metres: p = P q / 100 with P
// below, R = P Q P^T.
#include <cmath>
#include <numbers>

#include "io/file_bytes.h"
#include "io/text_scanner.h"
#include "io/trajectory_formats.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {
namespace {

constexpr double kCentimetres = 100.0;

Eigen::Matrix3d OursFrom3dtk() {
  return (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, 1, 0).finished();
}

Rigid3 ToOurs(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
              const std::string& file, std::size_t line) {
  const Eigen::Matrix3d ours_from_3dtk = OursFrom3dtk();
  return {CheckedRotation(ours_from_3dtk * rotation * ours_from_3dtk.transpose(), file, line),
          ours_from_3dtk * translation / kCentimetres};
}

std::vector<double> FiniteNumbers(std::string_view line) {
  std::vector<double> numbers;
  for (const std::string_view word : SplitWords(line)) {
    double number = 0.0;
    if (!ParseNumber(word, &number) || !std::isfinite(number)) return {};
    numbers.push_back(number);
  }
  return numbers;
}

// R = Rx Ry Rz (3DTK globals.icc, EulerToMatrix4).
Eigen::Matrix3d RotationOfEuler(const Eigen::Vector3d& degrees) {
  const Eigen::Vector3d angles = degrees * (std::numbers::pi / 180.0);
  return (Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(angles.z(), Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

// The inverse (3DTK globals.icc, Matrix4ToEuler), with theta_x = 0 where cos(theta_y) is near zero.
Eigen::Vector3d EulerOfRotation(const Eigen::Matrix3d& r) {
  constexpr double kGimbal = 0.005;
  Eigen::Vector3d angles;
  const double y = std::asin(std::clamp(r(0, 2), -1.0, 1.0));
  angles.y() = r(0, 0) > 0.0 ? y : std::numbers::pi - y;
  const double cosine = std::cos(angles.y());
  if (std::abs(cosine) > kGimbal) {
    angles.x() = std::atan2(-r(1, 2) / cosine, r(2, 2) / cosine);
    angles.z() = std::atan2(-r(0, 1) / cosine, r(0, 0) / cosine);
  } else {
    angles.x() = 0.0;
    angles.z() = std::atan2(r(1, 0), r(1, 1));
  }
  return angles * (180.0 / std::numbers::pi);
}

}  // namespace

Rigid3 Parse3dtkFrames(std::string_view bytes, const std::string& file) {
  LineReader lines(bytes);
  std::string_view line, last;
  std::size_t number = 0;
  while (lines.Next(&line)) {
    if (Trim(line).empty()) continue;
    last = line;
    number = lines.number();
  }
  if (number == 0) throw InputError::InFile(file, "holds no poses");
  const auto values = FiniteNumbers(last);
  if (values.size() != 17) {
    throw InputError::AtLine(file, number, "a .frames line has 16 numbers and a type");
  }
  const Eigen::Map<const Eigen::Matrix4d> matrix(values.data());
  return ToOurs(matrix.topLeftCorner<3, 3>(), matrix.topRightCorner<3, 1>(), file, number);
}

Rigid3 Parse3dtkPose(std::string_view bytes, const std::string& file) {
  std::vector<double> values;
  LineReader lines(bytes);
  std::string_view line;
  while (values.size() < 6 && lines.Next(&line)) {
    if (Trim(line).empty()) continue;
    const auto row = FiniteNumbers(line);
    if (row.size() != 3) throw InputError::AtLine(file, lines.number(), "needs three numbers");
    values.insert(values.end(), row.begin(), row.end());
  }
  if (values.size() < 6) {
    throw InputError::InFile(file, "needs two lines: the position and the Euler angles");
  }
  return ToOurs(RotationOfEuler({values[3], values[4], values[5]}),
                {values[0], values[1], values[2]}, file, lines.number());
}

Rigid3 Read3dtkFrames(const std::string& path) {
  return Parse3dtkFrames(FileBytes(path).view(), path);
}

Rigid3 Read3dtkPose(const std::string& path) { return Parse3dtkPose(FileBytes(path).view(), path); }

void Write3dtkFrames(const std::string& path, const Rigid3& world_from_scan) {
  constexpr int kTypeLum = 3;
  const Eigen::Matrix3d dtk_from_ours = OursFrom3dtk().transpose();
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() =
      dtk_from_ours * world_from_scan.rotation.toRotationMatrix() * dtk_from_ours.transpose();
  matrix.topRightCorner<3, 1>() = kCentimetres * (dtk_from_ours * world_from_scan.translation);
  std::string text;
  for (int i = 0; i < 16; ++i) {
    AppendNumber(&text, matrix.data()[i]);
    text += ' ';
  }
  WriteTextFile(path, text + std::to_string(kTypeLum) + "\n");
}

void Write3dtkPose(const std::string& path, const Rigid3& world_from_scan) {
  const Eigen::Matrix3d dtk_from_ours = OursFrom3dtk().transpose();
  const Eigen::Matrix3d rotation =
      dtk_from_ours * world_from_scan.rotation.toRotationMatrix() * dtk_from_ours.transpose();
  std::string text;
  for (const Eigen::Vector3d& row :
       {Eigen::Vector3d(kCentimetres * (dtk_from_ours * world_from_scan.translation)),
        EulerOfRotation(rotation)}) {
    for (int axis = 0; axis < 3; ++axis) {
      AppendNumber(&text, row[axis]);
      text += axis < 2 ? ' ' : '\n';
    }
  }
  WriteTextFile(path, text);
}

}  // namespace planegraph
