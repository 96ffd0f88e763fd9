#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "planegraph/geometry/rigid3.h"

namespace planegraph {

/// A camera of a photogrammetric model. Its frame is x right, y down, z forward, whatever the
/// file's own convention is; the model's frame and unit are arbitrary.
struct Camera {
  std::string image;   ///< name as in the file; empty where the format has none
  bool valid = false;  ///< false: the image was not registered, the pose means nothing
  Rigid3 camera_from_model;
  double focal = 0.0;  ///< in the file's own unit (pixels, or image widths); 0: unknown

  /// The projection centre in the model's frame.
  Eigen::Vector3d Centre() const { return camera_from_model.Inverse().translation; }
};

/// What the structure-from-motion step left: cameras and its sparse points.
struct CameraModel {
  std::vector<Camera> cameras;  ///< row k is camera k of the file, unregistered ones included
  std::vector<Eigen::Vector3d> points;  ///< in the model's frame; may be empty
  std::string format;                   ///< mve, bundler, colmap, opensfm
  std::size_t ignored_models = 0;       ///< further reconstructions in the file (OpenSfM)
};

/// Reads the cameras of
/// - MVE (`synth_0.out`, first line `drews 1.0`; cameras with f = 0 are not valid);
/// - Bundler v0.3 (its cameras look along -z and are turned here; a `list.txt` beside the file
///   gives the names);
/// - COLMAP: a folder with images.txt or images.bin (and cameras, points3D likewise, where
///   present), or the path of one of these; the order is that of the file;
/// - OpenSfM: reconstruction.json, its first reconstruction.
/// Throws InputError with line or byte; also where the file has no camera.
CameraModel ReadCameras(const std::string& path);

/// Writes MVE's format (numbers in full precision, points without colours and views), atomically.
/// Cameras that are not valid become zeros; a valid one without a focal length gets 1. Names are
/// lost.
void WriteMveCameras(const std::string& path, const CameraModel& model);

}  // namespace planegraph
