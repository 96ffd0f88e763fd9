#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/pipeline/mapper.h"

namespace planegraph {

/// `map` with one thread, several times: each time is the least of all runs, since whatever else
/// the machine does only adds to it. Everything else is the same in each run.
MapResult MapTimed(const Site& site, const std::string& optimizer, int runs);

/// The site without its drone maps and start poses.
Site LaserOnly(Site site);

/// Errors of a robot's trajectory against its reference.
struct RobotErrors {
  AteResult ate;
  RpeResult rpe;
};
/// Absent where the robot has no reference or a single scan.
std::optional<RobotErrors> ErrorsOf(const MapResult& result, std::size_t robot);

/// Truth by the references: target_from_source of two scans of one robot. Absent without one.
std::optional<Rigid3> ReferenceStep(const MapResult& result, std::size_t target,
                                    std::size_t source);

}  // namespace planegraph
