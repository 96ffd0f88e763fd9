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

/// Odometry between two scans with its covariance, INTERFACE order in the target's axes.
struct OdometryStep {
  std::size_t target = 0, source = 0;
  Rigid3 target_from_source;
  Matrix6d covariance = Matrix6d::Identity();
};

/// What a tracked or wheeled robot's odometry is worth: it errs with the way and with the turn
/// (ALGORITHMS 6.6). CalibrateOdometry widens it to what the registrations say.
Matrix6d OdometryCovariance(const Rigid3& target_from_source);

/// The odometry steps between consecutive scans of each robot.
std::vector<OdometryStep> OdometrySteps(const Site& site, const std::vector<ScanRecord>& scans);

/// Scales the covariances (never down) so that the differences to the used registrations are what
/// they say: a robust estimate, one factor for translation and one for rotation. False where fewer
/// than three steps could be compared: the covariances stay what is usual.
bool CalibrateOdometry(const std::vector<PairRecord>& pairs, std::vector<OdometryStep>* steps);

/// Registers each scan to the one before it (step p of the paper): from the odometry where there is
/// one, without a guess where that fails or there is none.
std::vector<PairRecord> RegisterChain(const std::vector<ScanModel>& models,
                                      const std::vector<ScanRecord>& scans,
                                      const std::vector<OdometryStep>& odometry,
                                      const RegistrationOptions& options, int threads);

/// Registrations of consecutive scans that contradict the calibrated odometry beyond all chance:
/// halls with equal bays look the same from each. The one from the odometry takes their place where
/// it is good enough; else they are ambiguous and not used.
void ResolveContradictions(const std::vector<ScanModel>& models,
                           const std::vector<OdometryStep>& odometry,
                           const RegistrationOptions& options, int threads,
                           std::vector<PairRecord>* chain);

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
