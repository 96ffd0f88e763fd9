#include "planegraph/correspondence/hypotheses.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "correspondence/rotation_hypotheses.h"
#include "correspondence/translation_votes.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr double kHardlyAny = 0.02;    // of the surfaces
constexpr double kLeastCosine = 0.94;  // 20 degrees between surfaces that shall be one
constexpr double kFreeMargin = 0.5;    // metres a beam must pass beyond a place to deny it
constexpr double kDistinctMetres = 1.0, kDistinctRadians = 0.17;
// Steps along a direction that no plane fixes: the verification may still know more.
constexpr double kOpenStep = 1.0;
constexpr int kOpenSteps = 8;

struct Translation {
  Eigen::Vector3d value;
  double weight;  ///< of its peaks, each relative to the best of its axis
};

void AddOpenAxes(std::vector<AxisVotes>* axes) {
  if (axes->size() == 1) {
    axes->push_back({TangentBasis(axes->front().axis).col(0), {{0.0, 1.0}}});
  }
  if (axes->size() == 2) {
    AxisVotes open{(*axes)[0].axis.cross((*axes)[1].axis).normalized(), {}};
    for (int k = -kOpenSteps; k <= kOpenSteps; ++k) open.peaks.push_back({k * kOpenStep, 1.0});
    axes->push_back(open);
  }
}

// Combinations of one peak per axis, those with the strongest peaks; axes that are missing get the
// open steps.
std::vector<Translation> CombinePeaks(std::vector<AxisVotes> axes, std::size_t most) {
  if (axes.empty()) return {};
  AddOpenAxes(&axes);
  Eigen::Matrix3d rows;
  for (int k = 0; k < 3; ++k) rows.row(k) = axes[k].axis.transpose();
  const Eigen::Matrix3d inverse = rows.inverse();
  const double strongest =
      axes[0].peaks[0].weight * axes[1].peaks[0].weight * axes[2].peaks[0].weight;
  std::vector<Translation> all;
  for (const auto& a : axes[0].peaks) {
    for (const auto& b : axes[1].peaks) {
      for (const auto& c : axes[2].peaks) {
        all.push_back({inverse * Eigen::Vector3d(a.value, b.value, c.value),
                       a.weight * b.weight * c.weight / strongest});
      }
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  if (all.size() > most) all.resize(most);
  return all;
}

bool SamePose(const Rigid3& a, const Rigid3& b) {
  return (a.translation - b.translation).norm() < kDistinctMetres &&
         AngleBetween(a.rotation, b.rotation) < kDistinctRadians;
}

void KeepDistinct(const HypothesisOptions& options, std::vector<PoseHypothesis>* all) {
  std::stable_sort(all->begin(), all->end(), [](const auto& a, const auto& b) {
    return a.support.Score() > b.support.Score();
  });
  std::vector<const PoseHypothesis*> kept;
  for (auto& candidate : *all) {
    if (!candidate.rejected.empty()) continue;
    if (kept.size() == options.most_kept) {
      candidate.rejected = "less support than the " + std::to_string(kept.size()) + " best";
    } else if (std::any_of(kept.begin(), kept.end(), [&](const PoseHypothesis* k) {
                 return SamePose(k->target_from_source, candidate.target_from_source);
               })) {
      candidate.rejected = "same pose as a better one";
    } else {
      kept.push_back(&candidate);
    }
  }
  if (!options.keep_rejected) {
    std::erase_if(*all, [](const PoseHypothesis& h) { return !h.rejected.empty(); });
  }
}

// Support by every stride-th sample from `first` on, added up without normalization.
Support PartialSupport(const ScanModel& target, const ScanModel& source, const Rigid3& pose,
                       double gate, std::size_t first, std::size_t stride) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  Support support;
  for (std::size_t k = first; k < source.samples.size(); k += stride) {
    const Surfel& surfel = source.map.surfels()[source.samples[k]];
    const Eigen::Vector3d point = rotation * surfel.mean + pose.translation;
    const Eigen::Vector3d normal = rotation * surfel.normal;
    const double weight = source.sample_weights[k];
    if (target.map.Find(point, normal, gate, kLeastCosine) >= 0) {
      support.agree += weight;
      support.agree_by_direction += weight * normal * normal.transpose();
    } else if (target.planes->range_image.Classify(point, kFreeMargin) ==
               RangeImage::Space::kFree) {
      support.violate += weight;
      support.violate_by_direction += weight * normal * normal.transpose();
    } else {
      support.unknown += weight;
    }
  }
  return support;
}

// All candidates by an eighth of the samples, the better ones by the rest too: most are wrong, and
// few samples tell.
void Verify(const ScanModel& target, const ScanModel& source, const HypothesisOptions& options,
            std::vector<PoseHypothesis>* all) {
  constexpr std::size_t kStride = 8;
  for (auto& h : *all) {
    h.support = PartialSupport(target, source, h.target_from_source, options.gate, 0, kStride);
  }
  std::stable_sort(all->begin(), all->end(), [](const auto& a, const auto& b) {
    return a.support.Score() > b.support.Score();
  });
  for (std::size_t i = 0; i < all->size(); ++i) {
    PoseHypothesis& h = (*all)[i];
    if (i >= options.most_verified) {
      h.rejected = "little support in a first look";
      continue;
    }
    h.support = MeasureSupport(target, source, h.target_from_source, options.gate);
  }
}

}  // namespace

double Support::WorstDirection() const {
  // Directions that hardly any surface faces do not count.
  const double floor = kHardlyAny * (agree + violate + unknown);
  const Eigen::Matrix3d all =
      agree_by_direction + violate_by_direction + floor * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d good = agree_by_direction + floor * Eigen::Matrix3d::Identity();
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix3d>(good, all,
                                                                   Eigen::EigenvaluesOnly)
      .eigenvalues()[0];
}

bool Support::IsFaced(const Eigen::Vector3d& direction) const {
  return direction.dot(agree_by_direction * direction) > kHardlyAny * agree;
}

Support MeasureSupport(const ScanModel& target, const ScanModel& source,
                       const Rigid3& target_from_source, double gate) {
  return PartialSupport(target, source, target_from_source, gate, 0, 1);
}

std::vector<PoseHypothesis> FindHypotheses(const ScanModel& target, const ScanModel& source,
                                           const HypothesisOptions& options) {
  std::vector<PoseHypothesis> all;
  for (const auto& rotation :
       FindRotations(target.directions, source.directions, options.most_rotations)) {
    const Eigen::Quaterniond q(rotation.target_from_source);
    const auto axes =
        VoteTranslations(target, source, rotation.target_from_source, options.peaks_per_axis);
    for (const auto& t : CombinePeaks(axes, options.most_translations)) {
      all.push_back({Rigid3(q, t.value), {}, {}});
    }
  }
  Verify(target, source, options, &all);
  KeepDistinct(options, &all);
  return all;
}

}  // namespace planegraph
