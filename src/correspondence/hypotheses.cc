#include "planegraph/correspondence/hypotheses.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "correspondence/first_look.h"
#include "correspondence/rotation_hypotheses.h"
#include "correspondence/translation_votes.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

constexpr double kHardlyAny = 0.02;  // of the surfaces
constexpr double kDistinctMetres = 1.0, kDistinctRadians = 0.17;
// Steps along a direction that no plane fixes: the verification may still know more.
constexpr double kOpenStep = 1.0;
constexpr int kOpenSteps = 8;

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

// Combinations of one peak per axis, those with the strongest peaks, best first; axes that are
// missing get the open steps.
std::vector<Eigen::Vector3d> CombinePeaks(std::vector<AxisVotes> axes, std::size_t most) {
  if (axes.empty()) return {};
  AddOpenAxes(&axes);
  Eigen::Matrix3d rows;
  for (int k = 0; k < 3; ++k) rows.row(k) = axes[k].axis.transpose();
  struct Combination {
    double weight;
    std::uint32_t i, j, k;
    bool operator<(const Combination& other) const {
      return std::tie(other.weight, i, j, k) < std::tie(weight, other.i, other.j, other.k);
    }
  };
  std::vector<Combination> all;
  // Peaks are in order: what has `most` combinations of peaks before it is not among the best.
  const auto &a = axes[0].peaks, &b = axes[1].peaks, &c = axes[2].peaks;
  for (std::uint32_t i = 0; i < a.size(); ++i) {
    for (std::uint32_t j = 0; j < b.size() && (i + 1) * (j + 1) <= most; ++j) {
      for (std::uint32_t k = 0; k < c.size() && (i + 1) * (j + 1) * (k + 1) <= most; ++k) {
        all.push_back({a[i].weight * b[j].weight * c[k].weight, i, j, k});
      }
    }
  }
  const std::size_t count = std::min(most, all.size());
  std::partial_sort(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count), all.end());
  const Eigen::Matrix3d inverse = rows.inverse();
  std::vector<Eigen::Vector3d> translations;
  for (std::size_t n = 0; n < count; ++n) {
    const auto& [weight, i, j, k] = all[n];
    translations.emplace_back(inverse * Eigen::Vector3d(a[i].value, b[j].value, c[k].value));
  }
  return translations;
}

bool SamePose(const Rigid3& a, const Rigid3& b) {
  return (a.translation - b.translation).norm() < kDistinctMetres &&
         AngleBetween(a.rotation, b.rotation) < kDistinctRadians;
}

// A hypothesis and its score by the looks so far, which see a part of the samples each.
struct Candidate {
  PoseHypothesis hypothesis;
  double score;
};

// Says of all but the best, distinct ones why they are dropped.
void RejectOthers(const HypothesisOptions& options, std::vector<Candidate>* all) {
  std::stable_sort(all->begin(), all->end(),
                   [](const auto& a, const auto& b) { return a.score > b.score; });
  std::vector<const PoseHypothesis*> kept;
  for (auto& [candidate, score] : *all) {
    if (!candidate.rejected.empty()) continue;
    const Rigid3& pose = candidate.target_from_source;
    if (kept.size() == options.most_kept) {
      candidate.rejected = "less support than the " + std::to_string(kept.size()) + " best";
    } else if (std::any_of(kept.begin(), kept.end(), [&](const PoseHypothesis* k) {
                 return SamePose(k->target_from_source, pose);
               })) {
      candidate.rejected = "same pose as a better one";
    } else {
      kept.push_back(&candidate);
    }
  }
}

// By every stride-th sample from `first` on.
void AddSupport(const ScanModel& target, const ScanModel& source, double gate, std::size_t first,
                std::size_t stride, PoseHypothesis* hypothesis) {
  const Rigid3& target_from_source = hypothesis->target_from_source;
  Support* support = &hypothesis->support;
  const Eigen::Matrix3d rotation = target_from_source.rotation.toRotationMatrix();
  for (std::size_t k = first; k < source.samples.size(); k += stride) {
    const Surfel& surfel = source.map.surfels()[source.samples[k]];
    const Eigen::Vector3d point = rotation * surfel.mean + target_from_source.translation;
    const Eigen::Vector3d normal = rotation * surfel.normal;
    const double weight = source.sample_weights[k];
    if (target.map.Find(point, normal, gate, kLeastCosine) >= 0) {
      support->agree += weight;
      support->agree_by_direction += weight * normal * normal.transpose();
    } else if (target.planes->range_image.IsFree(point, kFreeMargin)) {
      support->violate += weight;
      support->violate_by_direction += weight * normal * normal.transpose();
    } else {
      support->unknown += weight;
    }
  }
}

// Poses by rotation and by combination of peaks; the better ones by a quarter more of the samples.
std::vector<Candidate> LookTwice(const ScanModel& target, const ScanModel& source,
                                 const HypothesisOptions& options) {
  const auto rotations =
      FindRotations(target.directions, source.directions, options.most_rotations);
  FirstLook first(target, source, options);
  for (std::size_t k = 0; k < rotations.size(); ++k) {
    const Eigen::Matrix3d& rotation = rotations[k].target_from_source;
    const auto axes = VoteTranslations(target, source, rotation, options.peaks_per_axis);
    first.Look(k, rotation, CombinePeaks(axes, options.most_translations));
  }
  static_assert(FirstLook::kStride % 4 == 0, "the second look has other samples");
  std::vector<Candidate> candidates;
  for (const auto& c : first.TakeRanked()) {
    const Eigen::Quaterniond rotation(rotations[c.rotation].target_from_source);
    PoseHypothesis h{Rigid3(rotation, c.translation), {}, {}};
    if (candidates.size() < options.most_verified) {
      AddSupport(target, source, options.gate, 2, 4, &h);
      candidates.push_back({h, c.score + h.support.Score()});
    } else if (options.keep_rejected) {
      h.rejected = "little support in a first look";
      candidates.push_back({h, c.score});
    } else {
      break;
    }
  }
  return candidates;
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
  PoseHypothesis hypothesis{target_from_source, {}, {}};
  AddSupport(target, source, gate, 0, 1, &hypothesis);
  return hypothesis.support;
}

std::vector<PoseHypothesis> FindHypotheses(const ScanModel& target, const ScanModel& source,
                                           const HypothesisOptions& options) {
  std::vector<Candidate> candidates = LookTwice(target, source, options);
  RejectOthers(options, &candidates);
  std::vector<PoseHypothesis> all;
  for (auto& [h, score] : candidates) {
    if (h.rejected.empty()) {  // all samples that the second look left out
      AddSupport(target, source, options.gate, 0, 4, &h);
      AddSupport(target, source, options.gate, 1, 2, &h);
    }
    if (h.rejected.empty() || options.keep_rejected) all.push_back(std::move(h));
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
    return a.support.Score() > b.support.Score();
  });
  return all;
}

}  // namespace planegraph
