#include "planegraph/registration/map_evidence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "planegraph/registration/map_refinement.h"
#include "registration/map_word.h"

namespace planegraph {
namespace {

constexpr std::size_t kEvidenceSamples = 256;  // of each scan
constexpr double kPierceMargin = 0.7;          // metres that a beam must go on beyond a surface
constexpr double kViewRadius = 25.0;  // metres about a scan in which the map is looked through
constexpr std::size_t kMostViewed = 600;
// Of the surfaces that the map speaks about, the share that it contradicts at a right pose: things
// that moved, errors of the map. Where the map's frame does not say which way is up, every miss is
// a contradiction, and half of them are to be expected.
constexpr double kContradicted = 0.1, kMissed = 0.5;
// Of the map's surfaces that a laser sees from a right pose, the share that it seems to look
// through: edges within a pixel, glass, gaps between sparse beams.
constexpr double kPierced = 0.15;
// A wrong pose confirms at most half of what the map speaks about: what confirms more shares
// surfaces with the truth and is a rival, no background.
constexpr double kLeastBackground = 0.05, kMostBackground = 0.5;

// Weights by the blocks that surfaces lie in: what lies in one block is one observation.
class Blocks {
 public:
  void Add(const Eigen::Vector3d& place, const Eigen::Vector3d& normal, double weight) {
    weights_.emplace_back(MapBlock(place, normal), weight);
  }
  // Number of equally heavy blocks that would say as much.
  double Effective() {
    std::stable_sort(weights_.begin(), weights_.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    double sum = 0.0, squares = 0.0;
    for (std::size_t k = 0; k < weights_.size();) {
      const std::uint64_t block = weights_[k].first;
      double weight = 0.0;
      for (; k < weights_.size() && weights_[k].first == block; ++k) weight += weights_[k].second;
      sum += weight;
      squares += weight * weight;
    }
    return squares > 0.0 ? sum * sum / squares : 0.0;
  }

 private:
  std::vector<std::pair<std::uint64_t, double>> weights_;
};

// The map's surfaces about the scans that their lasers looked through, and that they met (m^2).
struct View {
  double pierced = 0.0, met = 0.0;
  Blocks blocks;
};

void LookThrough(const MapModel& map, const ScanModel& scan, const Sim3& map_from_scan,
                 View* view) {
  const auto section = map.Section(map_from_scan.translation, kViewRadius * map_from_scan.scale);
  const std::size_t stride = 1 + section.size() / kMostViewed;
  const Sim3 scan_from_map = map_from_scan.Inverse();
  for (std::size_t k = 0; k < section.size(); k += stride) {
    const Surfel& surfel = map.surfaces().surfels()[section[k]];
    // The back of a wall is hidden by its front; only what faces the scanner can be seen.
    if (surfel.normal.dot(map_from_scan.translation - surfel.mean) <= 0.0) continue;
    const auto space =
        scan.planes->range_image.Classify(scan_from_map * surfel.mean, kPierceMargin);
    if (space != RangeImage::Space::kFree && space != RangeImage::Space::kSurface) continue;
    (space == RangeImage::Space::kFree ? view->pierced : view->met) += surfel.area;
    view->blocks.Add(surfel.mean, surfel.normal, surfel.area);
  }
}

void MeasureView(const MapModel& map, const ScanGroup& group, const Sim3& map_from_group,
                 MapEvidence* evidence) {
  View view;
  for (std::size_t s = 0; s < group.scans.size(); ++s) {
    LookThrough(map, *group.scans[s], map_from_group * Sim3(group.group_from_scan[s]), &view);
  }
  if (view.pierced > 0.0) evidence->pierced = view.pierced / (view.pierced + view.met);
  evidence->viewed = view.blocks.Effective();
}

// What of one scan lies on the map, in sum and by direction.
struct Agreements {
  double agree = 0.0;
  Eigen::Matrix3d good = Eigen::Matrix3d::Zero(), all = Eigen::Matrix3d::Zero();
};

std::vector<Agreements> CompareSurfaces(const MapModel& map, const ScanGroup& group,
                                        const Sim3& map_from_group, double gate,
                                        MapEvidence* evidence) {
  std::vector<Agreements> scans(group.scans.size());
  const double share_of_scan = 1.0 / static_cast<double>(group.scans.size());
  const Eigen::Matrix3d rotation = map_from_group.rotation.toRotationMatrix();
  Blocks blocks;
  for (const GroupSample& s : SamplesOf(group, kEvidenceSamples)) {
    const Eigen::Vector3d normal = rotation * s.normal, place = map_from_group * s.mean;
    const Eigen::Matrix3d share = s.weight * normal * normal.transpose();
    const double weight = share_of_scan * s.weight;
    blocks.Add(s.mean, s.normal, weight);
    scans[s.scan].all += share;
    const int found = map.surfaces().Find(place, normal, gate, kSameFacing);
    const MapWord word = WordOf(map, found, place, normal);
    if (word == MapWord::kConfirmed) {
      scans[s.scan].good += share;
      scans[s.scan].agree += s.weight;
      evidence->confirmed += weight;
    } else if (word == MapWord::kContradicted) {
      evidence->contradicted += weight;
    }
  }
  evidence->surfaces = blocks.Effective();
  return scans;
}

// Mean and worst direction over the better half of the scans.
void JudgeBetterHalf(const std::vector<Agreements>& scans, MapEvidence* evidence) {
  std::vector<std::size_t> order(scans.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return scans[a].agree > scans[b].agree; });
  for (const Agreements& scan : scans) evidence->agree_by_scan.push_back(scan.agree);
  order.resize((scans.size() + 1) / 2);
  Eigen::Matrix3d good = Eigen::Matrix3d::Zero(), all = Eigen::Matrix3d::Zero();
  for (const std::size_t s : order) {
    evidence->agree += scans[s].agree / static_cast<double>(order.size());
    good += scans[s].good;
    all += scans[s].all;
  }
  const Eigen::Matrix3d floor = 0.02 * all.trace() * Eigen::Matrix3d::Identity();
  evidence->worst_direction = Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d>(
                                  good + floor, all + floor, Eigen::EigenvaluesOnly)
                                  .eigenvalues()[0];
}

// Chernoff's bound on the log-probability that of `trials` a share or more comes true.
double LogTail(double trials, double share, double expected) {
  if (share <= expected) return 0.0;
  const double rest =
      share < 1.0 ? (1.0 - share) * std::log((1.0 - share) / (1.0 - expected)) : 0.0;
  return -trials * (share * std::log(share / expected) + rest);
}

}  // namespace

double MapEvidence::ConfirmedShare() const {
  const double spoken = confirmed + contradicted;
  return spoken > 0.0 ? confirmed / spoken : 0.5;
}

MapEvidence MeasureEvidence(const MapModel& map, const ScanGroup& group, const Sim3& map_from_group,
                            double gate) {
  MapEvidence evidence;
  evidence.expected_contradicted = map.sky().known() ? kContradicted : kMissed;
  JudgeBetterHalf(CompareSurfaces(map, group, map_from_group, gate, &evidence), &evidence);
  MeasureView(map, group, map_from_group, &evidence);
  return evidence;
}

double BackgroundShare(const std::vector<const MapEvidence*>& wrong) {
  double confirmed = 0.0, spoken = 0.0;
  for (const MapEvidence* evidence : wrong) {
    confirmed += evidence->confirmed;
    spoken += evidence->confirmed + evidence->contradicted;
  }
  if (!(spoken > 0.0)) return kMostBackground;
  return std::clamp(confirmed / spoken, kLeastBackground, kMostBackground);
}

double LogLikelihoodRatio(const MapEvidence& evidence, double background) {
  const double expected = evidence.expected_contradicted;
  const double surfaces = evidence.confirmed * std::log((1.0 - expected) / background) +
                          evidence.contradicted * std::log(expected / (1.0 - background));
  return evidence.surfaces * surfaces + LogTail(evidence.viewed, evidence.pierced, kPierced);
}

}  // namespace planegraph
