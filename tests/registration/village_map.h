#pragma once

#include <cstdint>

#include "planegraph/correspondence/map_model.h"
#include "planegraph/correspondence/scan_model.h"
#include "planegraph/segmentation/map_segmenter.h"
#include "segmentation/vision_world.h"

namespace planegraph {

/// A drone's map of a world (the village) in a frame of its own, ready for registration.
class VillageMap {
 public:
  explicit VillageMap(const RayWorld& world = Village(), const Sim3& map_from_world = Sim3(),
                      const VisionNoise& noise = {}, std::uint64_t seed = 1)
      : planes_(Segment(SampleFaces(world, noise, seed), map_from_world)), model_(planes_) {}
  VillageMap(const VillageMap&) = delete;

  const PlaneSet& planes() const { return planes_; }
  const MapModel& model() const { return model_; }

 private:
  static PlaneSet Segment(Cloud cloud, const Sim3& map_from_world) {
    const Eigen::Matrix3f turn = map_from_world.rotation.toRotationMatrix().cast<float>();
    for (auto& p : cloud.points) {
      p = (map_from_world * Eigen::Vector3d(p.cast<double>())).cast<float>();
    }
    for (auto& n : cloud.normals) n = turn * n;
    MapSegmentationOptions options;
    options.segmentation = VisionOptions(cloud);
    options.threads = 2;
    return SegmentMap(cloud, options).planes;
  }

  PlaneSet planes_;
  MapModel model_;
};

/// A laser scan of a world, ready for registration.
class MadeScan {
 public:
  MadeScan(const RayWorld& world, const Rigid3& world_from_scan, std::uint64_t seed,
           int rays = 20000)
      : planes_(SegmentPlanes(ScanWorld(world, world_from_scan, rays, {0.005, 0.0}, seed).cloud)
                    .planes),
        model_(planes_) {}
  MadeScan(const MadeScan&) = delete;

  const PlaneSet& planes() const { return planes_; }
  const ScanModel& model() const { return model_; }

 private:
  PlaneSet planes_;
  ScanModel model_;
};

}  // namespace planegraph
