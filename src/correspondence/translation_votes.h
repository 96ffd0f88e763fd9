#pragma once

#include <vector>

#include "planegraph/correspondence/scan_model.h"

namespace planegraph {

/// A translation along one axis with its support.
struct VotePeak {
  double value;   ///< metres along the axis
  double weight;  ///< sum of the votes' weights
};

/// An axis (a direction of the target, up to sign) with the peaks of the votes along it.
struct AxisVotes {
  Eigen::Vector3d axis;
  std::vector<VotePeak> peaks;  ///< best first
};

/// For a known rotation: up to three axes that span the space, heaviest first, each with at most
/// `most_peaks` peaks. Fewer than three where the planes leave a direction open.
std::vector<AxisVotes> VoteTranslations(const ScanModel& target, const ScanModel& source,
                                        const Eigen::Matrix3d& rotation, std::size_t most_peaks);

/// Peaks of weighted votes: the windows of the given width that hold the most weight, by a sweep
/// over the sorted votes; windows that overlap a better one are dropped.
std::vector<VotePeak> FindPeaks(std::vector<VotePeak> votes, double width, std::size_t most);

}  // namespace planegraph
