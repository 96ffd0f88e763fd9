#pragma once

#include <gflags/gflags_declare.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/evaluation/interval.h"
#include "planegraph/evaluation/map_quality.h"
#include "planegraph/evaluation/trajectory_error.h"

DECLARE_string(reference);
DECLARE_string(estimate);
DECLARE_string(compare);
DECLARE_string(map);
DECLARE_string(scans);
DECLARE_string(plot);
DECLARE_string(align);
DECLARE_double(confidence);
DECLARE_double(delta);
DECLARE_double(max_time_difference);
DECLARE_double(max_range);
DECLARE_double(radius);
DECLARE_double(voxel);
DECLARE_uint64(every);
DECLARE_uint64(min_neighbours);
DECLARE_string(mode);
DECLARE_bool(mpv);
DECLARE_string(delta_unit);
DECLARE_string(pairs);
DECLARE_string(pairs_from);

namespace planegraph::tools {

/// What the flags ask for. They throw UsageError.
RpeOptions RpeFlags();
MapQualityOptions MapQualityFlags();

/// The parts of `evaluate`; each adds to the result and prints its tables.
void ReportTrajectory(nlohmann::json* result);
void ReportClouds(nlohmann::json* result);

/// What is known is written even where a part of it has no result; the reasons go along.
void NoteFailure(const std::string& what, const std::string& reason, nlohmann::json* result);
/// To stderr and to the result's `warnings`; one that is there already is not repeated.
void NoteWarnings(const std::vector<std::string>& warnings, nlohmann::json* result);

/// [low, high], or null.
nlohmann::json ToJson(const std::optional<Interval>& interval);
/// " (95 %: LOW to HIGH)", times `factor`; empty where there is none.
std::string IntervalText(const std::optional<Interval>& interval, double factor = 1.0);

}  // namespace planegraph::tools
