#pragma once

#include "planegraph/correspondence/map_model.h"

namespace planegraph {

/// What a map says of a surface that is believed to be at a place: it has one there that faces the
/// same way, it knows that none is there, or it does not know.
enum class MapWord { kConfirmed, kContradicted, kSilent };

/// Cosine between normals that face the same way.
inline constexpr double kSameFacing = 0.94;

/// `found`: the map's surfel at the place, -1: none (PatchMap::Find). Where the map's frame does
/// not say which way is up every miss contradicts.
inline MapWord WordOf(const MapModel& map, int found, const Eigen::Vector3d& place,
                      const Eigen::Vector3d& normal) {
  if (found >= 0) return MapWord::kConfirmed;
  const bool contradicted = !map.sky().known() || map.sky().Open(place, normal);
  return contradicted ? MapWord::kContradicted : MapWord::kSilent;
}

}  // namespace planegraph
