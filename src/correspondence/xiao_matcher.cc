#include "planegraph/correspondence/xiao_matcher.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

enum Rejection {
  kArea,
  kSameSegment,
  kParallel,
  kAngles,
  kTilted,
  kThirdParallel,
  kThirdAngle,
  kTooFar,
  kNoOverlap,
  kMoved,
  kRejections
};
constexpr std::array<const char*, kRejections> kReasons = {
    "areas differ",
    "a segment taken twice",
    "two planes nearly parallel",
    "angles between the planes differ",
    "z axis tilted",
    "third plane parallel to the line of the first two",
    "third normal differs",
    "translation too long",
    "planes do not overlap",
    "re-estimation moved the pose"};

double Radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

// A pair of segments of similar area; the source's plane is turned where its side is unknown.
struct PlanePair {
  std::int32_t target, source;
  Eigen::Vector3d target_normal, source_normal;
  double area_product, area_sum;
};

double Norm1(const Eigen::MatrixXd& matrix) { return matrix.cwiseAbs().sum(); }

struct Motion {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
};

struct Ranked {
  Motion motion;
  std::size_t count;
  double area_product;
};

class Search {
 public:
  Search(const PlaneSet& target, const PlaneSet& source, const XiaoOptions& options);
  XiaoMatch Run();

 private:
  void CollectCandidates();
  void AddCandidate(std::int32_t t, std::int32_t s);
  bool AnglesAgree(const PlanePair& a, const PlanePair& b);
  bool Upright(const Eigen::Matrix3d& rotation);
  bool ThirdAgrees(const PlanePair& a, const PlanePair& b, const PlanePair& c,
                   const Eigen::Matrix3d& rotation);
  void SearchFrom(std::size_t i, std::size_t j);
  void TryTriplet(const std::array<const PlanePair*, 3>& three);
  void TryPair(const PlanePair& a, const PlanePair& b);
  bool Overlap(const PlanePair& c, const Motion& motion) const;
  std::vector<const PlanePair*> Grow(const Motion& motion) const;
  void Keep(const Motion& motion);
  Motion Estimate(const std::vector<const PlanePair*>& pairs) const;
  XiaoSolution MakeSolution(const Motion& motion) const;
  void Choose();
  void Explain();
  bool Reject(Rejection why) { return rejected_[why]++, false; }

  const PlaneSet& target_;
  const PlaneSet& source_;
  const XiaoOptions& options_;
  const double cos_least_, sin_least_, cos_same_, cos_side_;
  std::vector<PlaneBox> target_boxes_, source_boxes_;
  std::vector<PlanePair> candidates_;
  std::vector<Ranked> ranked_;
  std::array<std::size_t, kRejections> rejected_{};
  bool pairs_only_ = false;
  XiaoMatch result_;
};

Search::Search(const PlaneSet& target, const PlaneSet& source, const XiaoOptions& options)
    : target_(target),
      source_(source),
      options_(options),
      cos_least_(std::cos(Radians(options.least_angle_deg))),
      sin_least_(std::sin(Radians(options.least_angle_deg))),
      cos_same_(std::cos(Radians(options.max_angle_difference_deg))),
      cos_side_(std::cos(Radians(options.max_side_tilt_deg))) {
  for (const auto& plane : target.planes) target_boxes_.push_back(MakePlaneBox(plane));
  for (const auto& plane : source.planes) source_boxes_.push_back(MakePlaneBox(plane));
}

void Search::AddCandidate(std::int32_t t, std::int32_t s) {
  const PlaneSegment &a = target_.planes[t], &b = source_.planes[s];
  candidates_.push_back({t, s, a.plane.normal, b.plane.normal, a.area * b.area, a.area + b.area});
  if (a.orientation == Orientation::kUnknown || b.orientation == Orientation::kUnknown) {
    candidates_.push_back(candidates_.back());
    candidates_.back().source_normal = -b.plane.normal;
  }
}

void Search::CollectCandidates() {
  for (std::size_t t = 0; t < target_.planes.size(); ++t) {
    for (std::size_t s = 0; s < source_.planes.size(); ++s) {
      const double a = target_.planes[t].area, b = source_.planes[s].area;
      if (std::min(a, b) < options_.min_area) continue;
      if (std::abs(a - b) > options_.max_area_difference * std::max(a, b)) {
        Reject(kArea);
      } else {
        AddCandidate(static_cast<std::int32_t>(t), static_cast<std::int32_t>(s));
      }
    }
  }
  // Large planes first: where the search is cut short, it has seen what counts most.
  std::stable_sort(candidates_.begin(), candidates_.end(),
                   [](const auto& a, const auto& b) { return a.area_product > b.area_product; });
  result_.area_pairs = candidates_.size();
}

bool Search::AnglesAgree(const PlanePair& a, const PlanePair& b) {
  if (a.target == b.target || a.source == b.source) return Reject(kSameSegment);
  const double t = a.target_normal.dot(b.target_normal), s = a.source_normal.dot(b.source_normal);
  if (std::max(std::abs(t), std::abs(s)) > cos_least_) return Reject(kParallel);
  const double difference = std::abs(std::acos(t) - std::acos(s));
  if (difference > Radians(options_.max_angle_difference_deg)) return Reject(kAngles);
  return true;
}

bool Search::Upright(const Eigen::Matrix3d& rotation) {
  return rotation(2, 2) >= cos_side_ || Reject(kTilted);
}

Eigen::Matrix3d RotationOfTwo(const PlanePair& a, const PlanePair& b) {
  return ProjectToRotation(a.target_normal * a.source_normal.transpose() +
                           b.target_normal * b.source_normal.transpose());
}

bool Search::ThirdAgrees(const PlanePair& a, const PlanePair& b, const PlanePair& c,
                         const Eigen::Matrix3d& rotation) {
  if (c.target == a.target || c.target == b.target || c.source == a.source ||
      c.source == b.source) {
    return Reject(kSameSegment);
  }
  // The third plane has to cut the intersection line of the first two.
  const Eigen::Vector3d line = a.target_normal.cross(b.target_normal).normalized();
  if (std::abs(line.dot(c.target_normal)) < sin_least_) return Reject(kThirdParallel);
  if (c.target_normal.dot(rotation * c.source_normal) < cos_same_) return Reject(kThirdAngle);
  return true;
}

bool Search::Overlap(const PlanePair& c, const Motion& motion) const {
  return BoxesOverlap(target_boxes_[c.target], source_boxes_[c.source], motion.rotation,
                      motion.translation, options_.overlap_tolerance);
}

void Search::TryTriplet(const std::array<const PlanePair*, 3>& three) {
  Motion motion;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero(), rows;
  for (const PlanePair* c : three) sum += c->target_normal * c->source_normal.transpose();
  motion.rotation = ProjectToRotation(sum);
  Eigen::Vector3d heights;
  for (int k = 0; k < 3; ++k) {
    rows.row(k) = three[k]->target_normal.transpose();
    heights[k] =
        three[k]->target_normal.dot(target_.planes[three[k]->target].centroid() -
                                    motion.rotation * source_.planes[three[k]->source].centroid());
  }
  motion.translation = rows.inverse() * heights;
  if (!(motion.translation.norm() <= options_.max_translation)) {
    Reject(kTooFar);
    return;
  }
  const bool overlap = std::all_of(three.begin(), three.end(),
                                   [&](const PlanePair* c) { return Overlap(*c, motion); });
  if (!overlap) {
    Reject(kNoOverlap);
    return;
  }
  Keep(motion);
}

void Search::Keep(const Motion& motion) {
  if (++result_.triplets >= options_.most_triplets) result_.capped = true;
  const auto pairs = Grow(motion);
  double product = 0.0;
  for (const PlanePair* c : pairs) product += c->area_product;
  ranked_.push_back({motion, pairs.size(), product});
}

// Two planes fix the rotation and two directions of translation; the third stays at zero.
void Search::TryPair(const PlanePair& a, const PlanePair& b) {
  Motion motion;
  motion.rotation = RotationOfTwo(a, b);
  if (!Upright(motion.rotation)) return;
  motion.translation = Estimate({&a, &b}).translation;
  if (!(motion.translation.norm() <= options_.max_translation)) {
    Reject(kTooFar);
  } else if (!Overlap(a, motion) || !Overlap(b, motion)) {
    Reject(kNoOverlap);
  } else {
    Keep(motion);
  }
}

void Search::SearchFrom(std::size_t i, std::size_t j) {
  const PlanePair &a = candidates_[i], &b = candidates_[j];
  if (!AnglesAgree(a, b)) return;
  if (pairs_only_) {
    TryPair(a, b);
    return;
  }
  const Eigen::Matrix3d rotation = RotationOfTwo(a, b);
  if (!Upright(rotation)) return;
  for (std::size_t k = j + 1; k < candidates_.size() && !result_.capped; ++k) {
    if (ThirdAgrees(a, b, candidates_[k], rotation)) TryTriplet({&a, &b, &candidates_[k]});
  }
}

// All pairs that agree with the motion, one to one: the nearer centroids win.
std::vector<const PlanePair*> Search::Grow(const Motion& motion) const {
  std::vector<std::pair<double, const PlanePair*>> found;
  for (const PlanePair& c : candidates_) {
    if (c.target_normal.dot(motion.rotation * c.source_normal) < cos_same_) continue;
    const Eigen::Vector3d apart = motion.rotation * source_.planes[c.source].centroid() +
                                  motion.translation - target_.planes[c.target].centroid();
    if (std::abs(c.target_normal.dot(apart)) > options_.max_offset_difference) continue;
    if (Overlap(c, motion)) found.emplace_back(apart.squaredNorm(), &c);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<const PlanePair*> pairs;
  for (const auto& [distance, c] : found) {
    const bool taken = std::any_of(pairs.begin(), pairs.end(), [c = c](const PlanePair* p) {
      return p->target == c->target || p->source == c->source;
    });
    if (!taken) pairs.push_back(c);
  }
  return pairs;
}

// Rotation weighted by the sum of areas, translation by a rank-revealing QR.
Motion Search::Estimate(const std::vector<const PlanePair*>& pairs) const {
  Motion motion;
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const PlanePair* c : pairs) {
    sum += c->area_sum * c->target_normal * c->source_normal.transpose();
  }
  motion.rotation = ProjectToRotation(sum);
  Eigen::MatrixX3d rows(pairs.size(), 3);
  Eigen::VectorXd heights(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const Eigen::Vector3d& n = pairs[k]->target_normal;
    rows.row(row) = n.transpose();
    heights[row] = n.dot(target_.planes[pairs[k]->target].centroid() -
                         motion.rotation * source_.planes[pairs[k]->source].centroid());
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixX3d> decomposition;
  // Below this share of the largest a direction comes from scatter of the normals.
  decomposition.setThreshold(std::sin(Radians(options_.max_angle_difference_deg)));
  motion.translation = decomposition.compute(rows).solve(heights);
  return motion;
}

XiaoSolution Search::MakeSolution(const Motion& motion) const {
  XiaoSolution solution;
  solution.target_from_source = {Eigen::Quaterniond(motion.rotation).normalized(),
                                 motion.translation};
  for (const PlanePair* c : Grow(motion)) {
    solution.pairs.push_back({c->target, c->source});
    solution.area_product += c->area_product;
  }
  return solution;
}

void Search::Choose() {
  std::stable_sort(ranked_.begin(), ranked_.end(), [](const Ranked& a, const Ranked& b) {
    return a.count != b.count ? a.count > b.count : a.area_product > b.area_product;
  });
  constexpr std::size_t kMost = 100;  // of equal count
  for (std::size_t k = 0; k < std::min(ranked_.size(), kMost); ++k) {
    if (k >= options_.least_candidates && ranked_[k].count < ranked_[0].count) break;
    const Motion refined = Estimate(Grow(ranked_[k].motion));
    if (Norm1(refined.rotation - ranked_[k].motion.rotation) > options_.max_rotation_change ||
        Norm1(refined.translation - ranked_[k].motion.translation) >
            options_.max_translation_change) {
      Reject(kMoved);
      continue;
    }
    result_.solutions.push_back(MakeSolution(refined));
  }
  std::stable_sort(result_.solutions.begin(), result_.solutions.end(),
                   [](const auto& a, const auto& b) {
                     return a.pairs.size() != b.pairs.size() ? a.pairs.size() > b.pairs.size()
                                                             : a.area_product > b.area_product;
                   });
}

void Search::Explain() {
  if (candidates_.empty()) {
    result_.reason = "no two segments have similar areas";
  } else if (ranked_.empty()) {
    result_.reason = "no two pairs of segments agree in a pose";
  } else if (result_.solutions.empty()) {
    result_.reason = "every solution moved away when it was estimated from all its pairs";
  } else if (result_.capped) {
    result_.reason = "stopped after " + std::to_string(result_.triplets) + " triplets";
  } else if (result_.two_directions_only) {
    result_.reason = "the matching planes face in two directions only";
  }
}

XiaoMatch Search::Run() {
  CollectCandidates();
  for (const bool pairs_only : {false, true}) {
    if (pairs_only && !ranked_.empty()) break;
    pairs_only_ = pairs_only;
    for (std::size_t i = 0; i < candidates_.size() && !result_.capped; ++i) {
      for (std::size_t j = i + 1; j < candidates_.size() && !result_.capped; ++j) SearchFrom(i, j);
    }
  }
  result_.two_directions_only = pairs_only_ && !ranked_.empty();
  Choose();
  Explain();
  for (int k = 0; k < kRejections; ++k) result_.rejected.emplace_back(kReasons[k], rejected_[k]);
  return std::move(result_);
}

}  // namespace

XiaoMatch MatchXiao(const PlaneSet& target, const PlaneSet& source, const XiaoOptions& options) {
  return Search(target, source, options).Run();
}

XiaoOptions XiaoOptions::Room() {
  XiaoOptions room;
  room.min_area = 1.0;
  room.max_area_difference = 0.4;
  room.max_angle_difference_deg = 4.0;
  room.max_side_tilt_deg = 20.0;
  room.max_translation = 4.5;
  room.max_offset_difference = 0.05;
  room.overlap_tolerance = 0.3;
  room.max_translation_change = 0.1;
  return room;
}

PlaneBox MakePlaneBox(const PlaneSegment& segment) {
  const SupportMask& mask = segment.mask;
  const double half = 0.5 * mask.cell_size;
  const double u = (2 * mask.min_i + mask.width) * half, v = (2 * mask.min_j + mask.height) * half;
  // The mask has an empty margin of two cells on every side.
  return {mask.origin + u * mask.u + v * mask.v, mask.u, mask.v, std::max(mask.width - 4, 1) * half,
          std::max(mask.height - 4, 1) * half};
}

bool BoxesOverlap(const PlaneBox& target, const PlaneBox& source, const Eigen::Matrix3d& rotation,
                  const Eigen::Vector3d& translation, double tolerance) {
  const Eigen::Vector3d apart = rotation * source.center + translation - target.center;
  const Eigen::Vector3d u = rotation * source.u, v = rotation * source.v;
  const auto overlap = [&](const Eigen::Vector3d& axis, double half) {
    const double reach =
        std::abs(axis.dot(u)) * source.half_u + std::abs(axis.dot(v)) * source.half_v;
    return std::abs(axis.dot(apart)) < half + reach + tolerance;
  };
  return overlap(target.u, target.half_u) && overlap(target.v, target.half_v);
}

}  // namespace planegraph
