#pragma once

#include "planegraph/registration/registration.h"

namespace planegraph {

inline bool Usable(const Registration& r) {
  return r.status == RegistrationStatus::kOk || r.status == RegistrationStatus::kDegenerate;
}

/// A prior that only matters where the surfaces leave something open; elsewhere even a wrong one
/// must not pull.
inline PosePrior WeakPrior(const Rigid3& guess) { return {guess, 1e4 * Matrix6d::Identity()}; }

}  // namespace planegraph
