#pragma once

#include <vector>

#include "planegraph/pipeline/pairing.h"

namespace planegraph {

/// Odometry between two scans with its covariance, INTERFACE order in the target's axes.
struct OdometryStep {
  std::size_t target = 0, source = 0;
  Rigid3 target_from_source;
  Matrix6d covariance = Matrix6d::Identity();
  std::size_t robot = 0;
  double sigma_scale = 0.0;  ///< of the length, an error that all steps of the robot have in common

  /// What the step errs by on its own: the covariance without the common part.
  Matrix6d OwnCovariance() const;
  /// Lengthens the step; what it errs by on its own stays.
  void Scale(double factor);
};

/// What an odometry is worth: it errs with the way and with the turn. CalibrateOdometry widens it
/// to what the registrations say.
Matrix6d OdometryCovariance(const Rigid3& target_from_source, const OdometryNoise& noise = {});

/// The odometry steps between consecutive scans of each robot, in the order of the scans.
std::vector<OdometryStep> OdometrySteps(const Site& site, const std::vector<ScanRecord>& scans);

/// The step between the scans of a pair; null where there is none.
const OdometryStep* FindStep(const std::vector<OdometryStep>& steps, const PairRecord& pair);

/// Registers each scan to the one before it (step p of the paper): from the odometry where there is
/// one, without a guess where that fails or there is none.
std::vector<PairRecord> RegisterChain(const std::vector<ScanModel>& models,
                                      const std::vector<ScanRecord>& scans,
                                      const std::vector<OdometryStep>& odometry,
                                      const RegistrationOptions& options, int threads);

/// How far the used registrations of consecutive scans are from the odometry: a robust standard
/// deviation of one axis. Zero where fewer than three steps could be compared.
struct OdometryScatter {
  double translation = 0.0;  ///< metres
  double rotation = 0.0;     ///< radians

  bool is_known() const { return translation > 0.0 && rotation > 0.0; }
};

/// Scales the covariances (never down) so that the differences to the used registrations are what
/// they say: a robust estimate, one factor for translation and one for rotation. With fewer than
/// three steps to compare the covariances stay what is usual.
OdometryScatter CalibrateOdometry(const std::vector<PairRecord>& chain,
                                  std::vector<OdometryStep>* steps);

/// The metres of a metre of each robot's odometry, by the used registrations along what they
/// observe and the prior OdometryStep::sigma_scale about 1; the steps are scaled by it. A
/// registration that contradicts its step has no say. By robot; 1 where there is nothing to
/// compare.
std::vector<double> ScaleOdometry(const std::vector<PairRecord>& chain, std::size_t robots,
                                  std::vector<OdometryStep>* steps);

/// Registrations of consecutive scans again, now that it is known what the odometry is worth:
/// 1. Where its scatter exceeds what a refinement reaches, a pose found from it may be a wrong one
///    nearby: it is searched for without a guess as well, and the better of the two stays.
/// 2. Registrations that contradict it beyond all chance, by its calibrated covariance and by the
///    scatter of all steps (halls with equal bays look the same from each): the one from the
///    odometry takes their place where it is good enough; else they are ambiguous and not used.
/// 3. Where the planes leave a direction open the odometry decides on it, as sure as it is.
/// Without a scatter only the last.
void ReviseChain(const std::vector<ScanModel>& models, const std::vector<OdometryStep>& odometry,
                 const OdometryScatter& scatter, const RegistrationOptions& options, int threads,
                 std::vector<PairRecord>* chain);

}  // namespace planegraph
