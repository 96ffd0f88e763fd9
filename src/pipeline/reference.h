#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "planegraph/evaluation/trajectory_error.h"
#include "planegraph/pipeline/mapper.h"

namespace planegraph {

// What is known of the truth, for evaluation alone.

/// A robot's poses with those of its reference. Throws InputError and NoResultError where the
/// reference does not fit.
PosePairs PairWithReference(const MapResult& result, std::size_t robot);

/// `reference` of report.json: how consistent errors and covariances are. What cannot be told is
/// left out.
nlohmann::json ReferenceJson(const MapResult& result);

}  // namespace planegraph
