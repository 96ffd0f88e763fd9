#pragma once

#include <vector>

#include "solve/pair_consensus.h"

namespace planegraph {

/// Which of the ways that surfaces face each landmark faces in the target, from 0 on: ways differ
/// by 15 degrees or more.
std::vector<std::size_t> DirectionsOf(const std::vector<SharedLandmark>& shared);

/// Surfaces that face one way count by the square root of their number: most of a yard's landmarks
/// lie on its ground, which agrees with any turn about the vertical and any place.
std::vector<double> WeightsOf(const std::vector<std::size_t>& direction_of);

}  // namespace planegraph
