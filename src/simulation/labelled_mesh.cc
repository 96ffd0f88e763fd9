#include "planegraph/simulation/labelled_mesh.h"

#include <Eigen/Geometry>

namespace planegraph {

int MeshBuilder::AddPlane(const Plane& plane) {
  mesh_.planes.push_back(plane);
  return static_cast<int>(mesh_.planes.size()) - 1;
}

void MeshBuilder::AddPolygon(const std::vector<Eigen::Vector3d>& corners, int label) {
  const int first = static_cast<int>(mesh_.vertices.size());
  mesh_.vertices.insert(mesh_.vertices.end(), corners.begin(), corners.end());
  for (int i = 1; i + 1 < static_cast<int>(corners.size()); ++i) {
    mesh_.triangles.emplace_back(first, first + i, first + i + 1);
    mesh_.labels.push_back(label);
  }
}

int MeshBuilder::AddFace(const std::vector<Eigen::Vector3d>& corners) {
  const int label = AddPlane(PlaneOfPolygon(corners));
  AddPolygon(corners, label);
  return label;
}

Plane PlaneOfPolygon(const std::vector<Eigen::Vector3d>& corners) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), center = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d a = corners[i] - corners[0];
    const Eigen::Vector3d b = corners[(i + 1) % corners.size()] - corners[0];
    normal += a.cross(b);
    center += corners[i] / static_cast<double>(corners.size());
  }
  normal.normalize();
  return {normal, normal.dot(center)};
}

}  // namespace planegraph
