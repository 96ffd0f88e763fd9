#pragma once

#include <string>
#include <vector>

#include "planegraph/correspondence/scan_model.h"
#include "planegraph/pipeline/front_end.h"
#include "planegraph/registration/registration.h"

namespace planegraph {

/// One registration between two scans, whether it was used or not.
struct PairRecord {
  std::size_t target = 0, source = 0;  ///< indices of scans
  Registration registration;
  bool used = false;
  double seconds = 0.0;
};

/// Registers pairs of scans that are no neighbours in time but see the same surfaces under the
/// given poses: loops, and the rest of the neighbourhood. At most `most_per_scan` for each scan.
/// Poses mean something between scans of one frame only (a number for each scan).
std::vector<PairRecord> RegisterNeighbours(const std::vector<ScanModel>& models,
                                           const std::vector<Rigid3>& world_from_scan,
                                           const std::vector<int>& frames,
                                           const std::vector<PairRecord>& known,
                                           const RegistrationOptions& options,
                                           std::size_t most_per_scan, int threads);

}  // namespace planegraph
