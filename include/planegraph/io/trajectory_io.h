#pragma once

#include <string>
#include <vector>

#include "planegraph/geometry/rigid3.h"

namespace planegraph {

/// Poses with time stamps (seconds), world_from_body. KITTI and 3DTK have no times: the 0-based
/// index then stands for it and has_times is false.
struct Trajectory {
  std::vector<double> times;
  std::vector<Rigid3> poses;
  bool has_times = true;
  /// The rotations as a file of matrices (KITTI) holds them, rounded and so not quite orthonormal;
  /// empty or one per pose. Errors of a hundredth of a millimetre depend on them.
  std::vector<Eigen::Matrix3d> matrices = {};
  /// How far the norm of a quaternion in the file lies from 1 at most.
  double norm_error = 0.0;

  std::size_t size() const { return poses.size(); }
};

/// Reads TUM (8 columns; quaternions are normalized, norms off by more than 1 % refused), KITTI (12
/// columns; a matrix that is not quite orthonormal becomes the nearest rotation) or a folder of
/// 3DTK .frames files (else .pose files, in name order), or the vertices of a g2o file, told apart
/// by the content. Throws InputError.
Trajectory ReadTrajectory(const std::string& path);

/// The times of poses whose own file has none (KITTI's times.txt, Rawseeds' lists): the first
/// number of each line, seconds; further columns (separated by blanks, ',' or ';'), empty lines and
/// lines that begin with '#' are passed over. Throws InputError, with the line.
std::vector<double> ReadTimeStamps(const std::string& path);

/// Writes TUM, full precision, atomically.
void WriteTum(const std::string& path, const Trajectory& trajectory);

/// Writes KITTI (row-major 3x4 per line), full precision, atomically.
void WriteKitti(const std::string& path, const Trajectory& trajectory);

/// The last line of a 3DTK .frames file, as a right-handed pose in metres (x forward, y left, z
/// up).
Rigid3 Read3dtkFrames(const std::string& path);
/// A 3DTK .pose file (position in cm, Euler angles in degrees, left-handed), converted likewise.
Rigid3 Read3dtkPose(const std::string& path);
/// One .frames file that holds the pose (type LUM), the exact inverse of Read3dtkFrames.
void Write3dtkFrames(const std::string& path, const Rigid3& world_from_scan);
/// A .pose file (centimetres, degrees), the inverse of Read3dtkPose up to rounding.
void Write3dtkPose(const std::string& path, const Rigid3& world_from_scan);

}  // namespace planegraph
