#include "planegraph/io/file_conventions.h"

#include <cmath>
#include <sstream>
#include <vector>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr std::string_view kAxes = "xyz";

Rigid3 Interpret(const FileConventions& conventions, Rigid3 pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  if (conventions.w_first) pose.rotation = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w());
  if (conventions.body_from_world) pose = pose.Inverse();
  const Eigen::Matrix3d& axes = conventions.axes;
  const Eigen::Matrix3d rotation = axes * pose.rotation.toRotationMatrix() * axes.transpose();
  // Without other axes the quaternion stays what it was, to the last bit.
  if (!axes.isIdentity(0.0)) pose.rotation = Eigen::Quaterniond(rotation).normalized();
  return {pose.rotation, conventions.scale * (axes * pose.translation)};
}

}  // namespace

Eigen::Matrix3d ParseAxes(const std::string& text) {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Zero();
  std::istringstream parts(text);
  int row = 0;
  for (std::string part; std::getline(parts, part, ','); ++row) {
    const bool minus = part.rfind('-', 0) == 0;
    const std::string name = part.substr(minus ? 1 : 0);
    const std::size_t column = name.size() == 1 ? kAxes.find(name) : kAxes.npos;
    if (row < 3 && column != kAxes.npos) {
      axes(row, static_cast<Eigen::Index>(column)) = minus ? -1.0 : 1.0;
    }
  }
  if (row != 3 || std::abs(axes.determinant()) != 1.0) {
    throw UsageError("axes are x, y and z in some order, each with or without a minus: not '" +
                     text + "'");
  }
  return axes;
}

std::string AxesText(const Eigen::Matrix3d& axes) {
  std::string text;
  for (Eigen::Index row = 0; row < 3; ++row) {
    for (Eigen::Index column = 0; column < 3; ++column) {
      if (axes(row, column) == 0.0) continue;
      text += text.empty() ? "" : ",";
      text += axes(row, column) < 0.0 ? "-" : "";
      text += kAxes[static_cast<std::size_t>(column)];
    }
  }
  return text;
}

Trajectory Interpret(const FileConventions& conventions, const Trajectory& as_read) {
  Trajectory trajectory = as_read;
  trajectory.matrices.clear();
  for (Rigid3& pose : trajectory.poses) pose = Interpret(conventions, pose);
  return trajectory;
}

Cloud Interpret(const FileConventions& conventions, Cloud as_read) {
  const Eigen::Matrix3d metric = conventions.scale * conventions.axes;
  as_read.offset = metric * as_read.offset;
  as_read.viewpoint = metric * as_read.viewpoint;
  for (auto& point : as_read.points) point = (metric * point.cast<double>()).cast<float>();
  for (auto& normal : as_read.normals) normal = conventions.axes.cast<float>() * normal;
  return as_read;
}

}  // namespace planegraph
