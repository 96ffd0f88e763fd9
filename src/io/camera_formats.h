#pragma once

#include <string>
#include <string_view>
#include <unordered_map>

#include "planegraph/io/camera_io.h"

// The readers of one format each, from a file's whole content; `file` is its name for messages.
// All throw InputError.

namespace planegraph {

/// MVE's bundle or Bundler v0.3, by the first line.
CameraModel ParseBundle(std::string_view bytes, const std::string& file);
bool LooksLikeBundle(std::string_view bytes);

CameraModel ParseOpenSfm(std::string_view bytes, const std::string& file);

/// Focal length by a camera's id.
using FocalLengths = std::unordered_map<long long, double>;
FocalLengths ParseColmapCameras(std::string_view bytes, const std::string& file);
FocalLengths ParseColmapCamerasBinary(std::string_view bytes, const std::string& file);
/// Images without a camera among `focal_lengths` have an unknown focal length.
std::vector<Camera> ParseColmapImages(std::string_view bytes, const FocalLengths& focal_lengths,
                                      const std::string& file);
std::vector<Camera> ParseColmapImagesBinary(std::string_view bytes,
                                            const FocalLengths& focal_lengths,
                                            const std::string& file);
std::vector<Eigen::Vector3d> ParseColmapPoints(std::string_view bytes, const std::string& file);
std::vector<Eigen::Vector3d> ParseColmapPointsBinary(std::string_view bytes,
                                                     const std::string& file);

}  // namespace planegraph
