#pragma once

#include <optional>
#include <string>
#include <vector>

#include "planegraph/registration/refinement.h"
#include "planegraph/registration/unobserved_direction.h"

namespace planegraph {

enum class RegistrationStatus { kOk, kDegenerate, kAmbiguous, kFailed };
const char* ToString(RegistrationStatus status);

struct RegistrationOptions {
  HypothesisOptions hypotheses;
  RefinementOptions refinement;
  double support_gate = 0.1;          ///< metres, of the final verification
  double least_quality = 0.2;         ///< of a pose to be believed; either way where nothing guides
  double least_quality_alone = 0.28;  ///< of one that no guess speaks for
  double ambiguity = 0.75;  ///< a second pose with this share of the best one's quality is one
  double weak_translation = 0.05;  ///< metres: a larger standard deviation is "not observed"
  double weak_rotation = 0.0175;   ///< radians, likewise
};

/// The pose between two scans and what is known of it.
struct Registration {
  RegistrationStatus status = RegistrationStatus::kFailed;
  std::string reason;
  Refinement refinement;  ///< the pose, its covariance and the plane pairs
  Support support;
  double quality = 0.0, runner_up = 0.0;
  /// Of the inverse pose: the target's surfaces in the source. By `Register` alone.
  std::optional<double> quality_back;
  std::vector<UnobservedDirection> unobserved;

  const Rigid3& target_from_source() const { return refinement.target_from_source; }
};

/// How far a pose can be believed, in [0, 1]: the share of the surfaces that agree less those that
/// violate free space, times the agreement in the worst direction.
double Quality(const Support& support);

/// Directions that the surfaces leave open: where hardly any of the agreeing ones face along it
/// (Support::IsFaced), the standard deviation is above the limits, noise of the normals alone would
/// explain the information (ALGORITHMS 3.2, rule 2), or the cost does not rise as the information
/// predicts (ObservedShare).
std::vector<UnobservedDirection> FindUnobserved(const ScanModel& target, const ScanModel& source,
                                                const Support& support,
                                                const Refinement& refinement,
                                                const RegistrationOptions& options);

/// Registers without a guess: hypotheses, refinement of each, and a decision by evidence. Says
/// `ambiguous` rather than guess when another pose explains nearly as much, and `failed` where only
/// one of the two scans has its surfaces explained.
Registration Register(const ScanModel& target, const ScanModel& source,
                      const RegistrationOptions& options = {});

/// Registers from a guess with its covariance: refinement from it, verified; no other pose is
/// tried.
Registration RegisterFromGuess(const ScanModel& target, const ScanModel& source,
                               const PosePrior& guess, const RegistrationOptions& options = {});

}  // namespace planegraph
