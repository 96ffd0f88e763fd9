#pragma once

#include <cstdint>
#include <string>

#include "planegraph/io/g2o_io.h"

namespace planegraph {

/// What a false loop closure measures. kLookalike: what a true one measured, between other places
/// (one place taken for another); kRandom: any rotation, and a translation of at most the graph's
/// extent; kGroups: runs of ten lookalikes i + n -> j + n, which support each other.
enum class FalseClosureKind { kRandom, kLookalike, kGroups };

/// "random", "lookalike", "groups". Throws UsageError for another name.
FalseClosureKind ParseFalseClosureKind(const std::string& name);

/// Adds `share` times as many false closures as the SE(3) graph has true ones (edges between ids
/// that are not consecutive), between poses drawn equally likely that are at least two apart and
/// have no edge, with the information of a true closure drawn likewise.
void AddFalseClosures(FalseClosureKind kind, double share, std::uint64_t seed, G2oGraph* graph);

}  // namespace planegraph
