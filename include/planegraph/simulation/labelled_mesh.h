#pragma once

#include <Eigen/Core>
#include <vector>

#include "planegraph/geometry/plane.h"

namespace planegraph {

/// The label of whatever is not planar: spheres, poles, leaves, and points between two surfaces.
inline constexpr int kNotPlanar = -1;

/// Triangles in the world frame, metres, where each knows the physical plane that it is part of.
struct LabelledMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;  ///< indices of vertices
  std::vector<int> labels;                 ///< per triangle: index into `planes`, or kNotPlanar
  /// One entry per physical plane; all faces of a wall's side share one. Normals point out of the
  /// solid.
  std::vector<Plane> planes;
};

/// Puts polygons together to a LabelledMesh.
class MeshBuilder {
 public:
  /// A new label.
  int AddPlane(const Plane& plane);
  /// A convex polygon in the plane `label` (not checked) or kNotPlanar.
  void AddPolygon(const std::vector<Eigen::Vector3d>& corners, int label);
  /// A convex planar polygon, counterclockwise from outside, with a new label, which is returned.
  int AddFace(const std::vector<Eigen::Vector3d>& corners);

  const LabelledMesh& mesh() const { return mesh_; }

 private:
  LabelledMesh mesh_;
};

/// The plane of a planar polygon of non-zero area, by the right-hand rule (Newell's method).
Plane PlaneOfPolygon(const std::vector<Eigen::Vector3d>& corners);

}  // namespace planegraph
