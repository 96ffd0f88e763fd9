#pragma once

#include <cstdint>
#include <random>

#include "segmentation/ray_world.h"

namespace planegraph {

/// A house that stands on foot: four walls and a flat roof, seen from outside. (A box has a bottom,
/// too, which no camera sees.)
inline void AddHouse(const Eigen::Vector3d& foot, const Eigen::Vector3d& size, double yaw,
                     RayWorld* world) {
  RayWorld box;
  box.AddBox(foot, size, yaw, 1.0);
  for (const Face& face : box.faces) {
    if (face.normal().z() > -0.5) world->faces.push_back(face);
  }
}

struct VisionNoise {
  double spacing = 0.15;       ///< between neighbouring points of a surface, metres
  double sigma = 0.02;         ///< of a point along its surface's normal, metres
  double normal_sigma = 0.09;  ///< each axis, radians
};

/// What multi-view stereo would make of a world: points all over its faces, normals towards the
/// cameras. `labels`: the face of each point.
inline Cloud SampleFaces(const RayWorld& world, const VisionNoise& noise, std::uint64_t seed,
                         std::vector<int>* labels = nullptr) {
  Cloud cloud;
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (std::size_t f = 0; f < world.faces.size(); ++f) {
    const Face& face = world.faces[f];
    const double area = 4.0 * face.half_u * face.half_v;
    const int count = static_cast<int>(area / (noise.spacing * noise.spacing));
    for (int k = 0; k < count; ++k) {
      const double u = face.half_u * uniform(engine), v = face.half_v * uniform(engine);
      const double height = noise.sigma * normal(engine);
      cloud.points.push_back(
          (face.centre + u * face.u + v * face.v + height * face.normal()).cast<float>());
      const double a = noise.normal_sigma * normal(engine), b = noise.normal_sigma * normal(engine);
      cloud.normals.push_back((face.normal() + a * face.u + b * face.v).normalized().cast<float>());
      if (labels != nullptr) labels->push_back(static_cast<int>(f));
    }
  }
  return cloud;
}

/// Ground and houses of all sizes and headings over some 50 x 40 m; no symmetry maps it onto
/// itself. A scanner stands well at (0, 0).
inline RayWorld Village() {
  RayWorld world;
  world.AddFace({2.0, 1.0, 0.0}, Eigen::Vector3d::UnitZ(), 19.0, 25.0);
  AddHouse({9.0, 5.0, 0.0}, {8.0, 6.0, 5.0}, 0.1, &world);
  AddHouse({-8.0, 8.0, 0.0}, {7.0, 9.0, 4.0}, 0.5, &world);
  AddHouse({-10.0, -7.0, 0.0}, {5.0, 6.0, 6.0}, -0.2, &world);
  AddHouse({5.0, -9.0, 0.0}, {12.0, 4.0, 3.5}, 0.25, &world);
  AddHouse({20.0, -4.0, 0.0}, {5.0, 9.0, 4.5}, 0.9, &world);
  AddHouse({3.0, 14.0, 0.0}, {4.0, 3.0, 2.5}, 0.7, &world);
  AddHouse({-18.0, 0.0, 0.0}, {3.0, 5.0, 3.0}, 1.2, &world);
  AddHouse({4.5, -2.5, 0.0}, {1.5, 2.5, 1.8}, 1.0, &world);
  return world;
}

}  // namespace planegraph
