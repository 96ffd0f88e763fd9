#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// A run with what a report can hold: two robots, a drone map, a fixed scan, an open direction, an
/// unused registration, errors against a reference.
inline nlohmann::json SampleReport() {
  return nlohmann::json::parse(R"json({
    "name": "yard", "components": 1, "peak_memory_bytes": 104857600, "seconds": 1.25,
    "scans": [
      {"id": "ugv/000", "points": 1234567, "points_filtered": 1200000, "planes": 40, "component": 0,
       "seconds": {"read": 0.01, "preprocess": 0.02, "segment": 0.03},
       "world_from_scan": {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1]},
       "covariance": [[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0],[0,0,0,0,0,0]],
       "unobserved": [], "anchored_to": ["uav"]},
      {"id": "ugv/001", "points": 1000, "points_filtered": 900, "planes": 30, "component": 0,
       "seconds": {"read": 0.01, "preprocess": 0.02, "segment": 0.04},
       "world_from_scan": {"translation": [4, 3, 0.1], "rotation": [0, 0, 0, 1]},
       "covariance": [[0.36,0,0,0,0,0],[0,1e-4,0,0,0,0],[0,0,1e-4,0,0,0],
                      [0,0,0,1e-6,0,0],[0,0,0,0,1e-6,0],[0,0,0,0,0,4e-6]],
       "unobserved": [{"direction": [1, 0, 0, 0, 0, 0], "sigma": 0.6, "held_by": "odometry"}]},
      {"id": "cart/000", "points": 1000, "points_filtered": 900, "planes": 3, "component": 0,
       "seconds": {"read": 0.01, "preprocess": 0.02, "segment": 0.04},
       "world_from_scan": {"translation": [8, 3, 0.1], "rotation": [0, 0, 0, 1]},
       "covariance": [[null,0,0,0,0,0],[0,1e-4,0,0,0,0],[0,0,1e-4,0,0,0],
                      [0,0,0,1e-6,0,0],[0,0,0,0,1e-6,0],[0,0,0,0,0,4e-6]],
       "unobserved": [{"direction": [0, 0, 0, 0, 0, 1], "sigma": null, "held_by": null}]}],
    "registrations": [
      {"target": "ugv/000", "source": "ugv/001", "kind": "laser-laser", "status": "ok", "reason": "",
       "correspondences": 12, "surfels": 345, "redundancy": 339, "tilt_rms": 0.00123,
       "covariance": [[9e-6,0,0,0,0,0],[0,1e-6,0,0,0,0],[0,0,1e-6,0,0,0],
                      [0,0,0,1e-8,0,0],[0,0,0,0,1e-8,0],[0,0,0,0,0,1e-8]], "rms": 0.0042, "quality": 0.91, "used": true, "seconds": 0.01},
      {"target": "ugv/000", "source": "cart/000", "kind": "laser-laser", "status": "ambiguous",
       "reason": "two poses explain the planes", "correspondences": 5, "rms": 0.03, "quality": 0.2,
       "used": false, "seconds": 0.02},
      {"target": "uav", "source": "ugv/000", "kind": "laser-map", "status": "ok", "reason": "",
       "correspondences": 21, "rms": 0.0173, "quality": 0.5, "used": true, "seconds": 0.03},
      {"target": "uav", "source": "ugv/001", "kind": "laser-map", "status": "failed",
       "reason": "not enough overlap: the map confirms 0 % of the surfaces", "correspondences": 0,
       "rms": null, "quality": 0, "used": false, "seconds": 0.01}],
    "origin": {"lat": 51.488, "lon": 7.493, "alt": 115},
    "maps": [{"id": "uav", "points": 660000, "planes": 1027, "noise": {"constant": 0.0228},
              "world_from_map": {"translation": [1, 2, 3], "rotation": [0, 0, 0, 1],
              "scale": 2.5}, "sigma_scale": 0.002, "cameras": [[1, 2, 30], [4, 5, 31]],
              "georeference": {"status": "ok", "reason": "", "scale": 2.45, "sigma_scale": 0.011,
                               "rms": 2.749, "inliers": 130, "fixes": 133}}],
    "solve": {"optimizer": "graph", "plane_factor": "moments", "loss": "cauchy:2.4",
              "costs": [[100.5, 40, 20], [30, 10.25]], "redundancy": 77,
              "initial_cost": 100.5, "final_cost": 10.25, "iterations": 7, "rounds": 2,
              "converged": true, "floor_offset": 0.002, "floor_tilt": 0.0005, "seconds": 0.1},
    "evaluation": {"ugv": {
      "ate": {"rmse": 0.0123, "mean": 0.01, "median": 0.01, "std": 0.001, "min": 0, "max": 0.02,
              "rotation": {"rmse": 0.017453292519943295, "max": 0.0349}, "count": 2,
              "each": [0.008, 0.02], "alignment": "first"},
      "rpe": {"rmse": 0.02, "mean": 0.02, "median": 0.02, "max": 0.02,
              "rotation": {"rmse": 0.01, "max": 0.01}, "count": 1, "delta": 1,
              "delta_unit": "frames", "pairs": "consecutive", "pairs_from": "reference"}}},
    "reference": {"consistency": {"pose_nees": 1.25, "degrees_of_freedom": 6, "joint": true,
      "band": [0.21, 2.41], "count": 1, "coverage": {"50": 0, "90": 1, "95": 1},
      "scale_nees": 0.5, "scale_coverage": {"50": 1, "90": 1, "95": 1},
      "robots": {"ugv": {"nees": 1.25, "degrees_of_freedom": 6, "joint": true, "band": [0.21, 2.41],
                         "count": 1, "coverage": {"50": 0, "90": 1, "95": 1}, "each": [1.25],
                         "relative_to": "ugv/000"}},
      "maps": {"uav": {"true_scale": 2.5, "nees": 0.5}}}},
    "observability": {"open_degrees_of_freedom": 1, "motions": [
      {"kind": "translation", "directions": [[1, 0, 0]], "parts": [["ugv/000", "ugv/001"], ["cart/000"]],
       "degrees_of_freedom": 1, "sigma": 0.6, "sigma_planes": null, "held_by": "odometry",
       "scan": "cart/000", "relative_to": "ugv/000",
       "text": "translation along (1.00, 0.00, 0.00): not observed by planes for 1 scan as a whole"}]},
    "stage_seconds": {"solve": 0.25, "front_end": 0.5, "maps": 0.4, "placing": 0.2},
    "planegraph": {"version": "0.1.0", "commit": "abc", "command": "planegraph map site.yaml",
                   "flags": {"loss": "huber:1"}, "seed": 3}
  })json");
}

/// A room of 10 x 6 m: floor at z = 0, ceiling at 2.5, walls, points every 5 cm.
inline Cloud RoomCloud(double slope = 0.0) {
  Cloud cloud;
  const auto add = [&](double x, double y, double z) {
    cloud.points.emplace_back(static_cast<float>(x), static_cast<float>(y),
                              static_cast<float>(z + slope * x));
  };
  for (int i = 0; i <= 200; ++i) {
    for (int j = 0; j <= 120; ++j) {
      add(0.05 * i, 0.05 * j, 0.0);
      add(0.05 * i, 0.05 * j, 2.5);
    }
    for (int k = 0; k <= 50; ++k) {
      add(0.05 * i, 0.0, 0.05 * k);
      add(0.05 * i, 6.0, 0.05 * k);
    }
  }
  for (int j = 0; j <= 120; ++j) {
    for (int k = 0; k <= 50; ++k) {
      add(0.0, 0.05 * j, 0.05 * k);
      add(10.0, 0.05 * j, 0.05 * k);
    }
  }
  return cloud;
}

}  // namespace planegraph
