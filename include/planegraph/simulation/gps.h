#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "planegraph/io/local_frame.h"
#include "planegraph/simulation/flight.h"
#include "planegraph/simulation/random.h"

namespace planegraph {

/// Errors of a drone's satellite receiver, east, north, up, metres.
struct GpsOptions {
  double period = 1.0;                         ///< seconds between fixes
  Eigen::Vector3d bias_sigma{0.6, 0.6, 1.0};   ///< constant, drawn once
  Eigen::Vector3d drift_sigma{1.2, 1.2, 1.6};  ///< a first-order Gauss-Markov process ...
  double drift_time = 40.0;                    ///< ... with this correlation time, seconds
  Eigen::Vector3d white_sigma{0.7, 0.7, 1.0};
  double outlier_share = 0.01, outlier_size = 12.0;  ///< fixes that are off by about so much
};

/// Fixes in the world frame, which is east-north-up.
struct SimulatedGps {
  std::vector<double> times;                       ///< seconds
  std::vector<Eigen::Vector3d> positions;          ///< metres
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();  ///< the truth about the constant part
};

/// Where the drone is at a time: straight on between two images.
Eigen::Vector3d PositionAt(const Flight& flight, double time);

/// Fixes from the first image to the last. Throws UsageError for options that make no sense.
SimulatedGps SimulateGps(const Flight& flight, const GpsOptions& options, Random* random);

/// The fixes as a CSV: time,lat,lon,alt.
std::string GpsText(const SimulatedGps& track, const GeodeticPosition& origin);

}  // namespace planegraph
