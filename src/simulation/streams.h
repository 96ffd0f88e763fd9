#pragma once

#include <cstdint>

namespace planegraph {

/// The streams of random numbers of a simulation's parts (see Random). Robot r adds r times
/// kStreamsPerRobot to its own ones.
inline constexpr std::uint64_t kSceneStream = 1, kDriveStream = 2, kOdometryStream = 3,
                               kStartStream = 4, kFlightStream = 5, kModelStream = 6,
                               kGpsStream = 7, kRobotGpsStream = 8, kFirstScanStream = 1000,
                               kFirstViewStream = 10000, kStreamsPerRobot = 1u << 20;

}  // namespace planegraph
