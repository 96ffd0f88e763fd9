#include "correspondence/translation_votes.h"

#include <algorithm>
#include <cmath>

namespace planegraph {
namespace {

constexpr double kSame = 0.99;         // cosine between a target direction and a rotated source one
constexpr double kWindow = 0.4;        // metres
constexpr double kIndependent = 0.35;  // least sine to a second axis, least volume with a third
constexpr std::size_t kPlanesPerDirection = 12;

void CollectVotes(const PlaneSet& target, const PlaneSet& source, const DirectionCluster& t,
                  const DirectionCluster& s, const Eigen::Matrix3d& rotation,
                  const Eigen::Vector3d& axis, std::vector<VotePeak>* votes) {
  const std::size_t n = std::min(kPlanesPerDirection, t.planes.size());
  const std::size_t m = std::min(kPlanesPerDirection, s.planes.size());
  for (std::size_t i = 0; i < n; ++i) {
    const PlaneSegment& pt = target.planes[t.planes[i]];
    for (std::size_t j = 0; j < m; ++j) {
      const PlaneSegment& ps = source.planes[s.planes[j]];
      // Heights over the axis at the two centroids: they differ by the translation along it.
      const double value = axis.dot(pt.centroid()) - axis.dot(rotation * ps.centroid());
      votes->push_back({value, std::sqrt(std::min(pt.area, ps.area))});
    }
  }
}

AxisVotes VoteAlong(const ScanModel& target, const ScanModel& source,
                    const Eigen::Matrix3d& rotation, const Eigen::Vector3d& axis,
                    std::size_t most_peaks) {
  std::vector<VotePeak> votes;
  for (const auto& t : target.directions) {
    if (std::abs(t.direction.dot(axis)) < kSame) continue;
    for (const auto& s : source.directions) {
      if (t.direction.dot(rotation * s.direction) < kSame) continue;
      CollectVotes(*target.planes, *source.planes, t, s, rotation, axis, &votes);
    }
  }
  return {axis, FindPeaks(std::move(votes), kWindow, most_peaks)};
}

// How far an axis stands out of the span of the chosen ones.
double Independence(const std::vector<AxisVotes>& chosen, const Eigen::Vector3d& axis) {
  if (chosen.empty()) return 1.0;
  if (chosen.size() == 1) return chosen[0].axis.cross(axis).norm();
  return std::abs(chosen[0].axis.cross(chosen[1].axis).dot(axis));
}

}  // namespace

std::vector<VotePeak> FindPeaks(std::vector<VotePeak> votes, double width, std::size_t most) {
  std::sort(votes.begin(), votes.end(),
            [](const VotePeak& a, const VotePeak& b) { return a.value < b.value; });
  std::vector<VotePeak> windows;
  windows.reserve(votes.size());
  double weight = 0.0, moment = 0.0;
  for (std::size_t first = 0, last = 0; first < votes.size(); ++first) {
    while (last < votes.size() && votes[last].value <= votes[first].value + width) {
      weight += votes[last].weight;
      moment += votes[last].weight * votes[last].value;
      ++last;
    }
    windows.push_back({moment / weight, weight});
    weight -= votes[first].weight;
    moment -= votes[first].weight * votes[first].value;
  }
  std::sort(windows.begin(), windows.end(), [](const VotePeak& a, const VotePeak& b) {
    return a.weight != b.weight ? a.weight > b.weight : a.value < b.value;
  });
  std::vector<VotePeak> peaks;
  for (const VotePeak& window : windows) {
    if (peaks.size() == most) break;
    const bool known = std::any_of(peaks.begin(), peaks.end(), [&](const VotePeak& peak) {
      return std::abs(peak.value - window.value) < width;
    });
    if (!known) peaks.push_back(window);
  }
  return peaks;
}

std::vector<AxisVotes> VoteTranslations(const ScanModel& target, const ScanModel& source,
                                        const Eigen::Matrix3d& rotation, std::size_t most_peaks) {
  std::vector<AxisVotes> chosen;
  for (const auto& direction : target.directions) {
    if (chosen.size() == 3) break;
    if (Independence(chosen, direction.direction) < kIndependent) continue;
    AxisVotes votes = VoteAlong(target, source, rotation, direction.direction, most_peaks);
    if (!votes.peaks.empty()) chosen.push_back(std::move(votes));
  }
  return chosen;
}

}  // namespace planegraph
