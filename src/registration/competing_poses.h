#pragma once

#include "planegraph/geometry/rigid3.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {

/// Whether two answers exclude each other. Poses nearer than this may be one basin of the
/// refinement: they do not compete.
inline bool Compete(const Rigid3& a, const Rigid3& b) {
  constexpr double kSameMetres = 0.5, kSameRadians = 0.09;
  return (a.translation - b.translation).norm() > kSameMetres ||
         AngleBetween(a.rotation, b.rotation) > kSameRadians;
}

}  // namespace planegraph
