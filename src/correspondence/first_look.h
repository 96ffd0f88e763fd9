#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <queue>
#include <vector>

#include "planegraph/correspondence/hypotheses.h"

namespace planegraph {

inline constexpr double kLeastCosine = 0.94;  // 20 degrees between surfaces that shall be one
inline constexpr double kFreeMargin = 0.5;    // metres a beam must pass beyond a place to deny it

/// A look at hypotheses by every eighth of the samples, under one rotation at a time: most are
/// wrong, and few samples tell.
class FirstLook {
 public:
  static constexpr std::size_t kStride = 8;  ///< of the samples, from the first on

  /// `rotation` is the index that was given with it. The score is exact for the best
  /// `most_verified`, the others have at most the least of theirs.
  struct Candidate {
    std::size_t place, rotation;
    Eigen::Vector3d translation;
    double score;  ///< share of the samples that agree less the share that contradicts
  };

  FirstLook(const ScanModel& target, const ScanModel& source, const HypothesisOptions& options)
      : target_(target), source_(source), options_(options) {}

  void Look(std::size_t rotation, const Eigen::Matrix3d& target_from_source,
            const std::vector<Eigen::Vector3d>& translations);

  /// All that were looked at, best first.
  std::vector<Candidate> TakeRanked();

 private:
  struct Sample {
    Eigen::Vector3d mean, normal;  // turned
    int side;
    double weight;
  };

  void Turn(const Eigen::Matrix3d& rotation);
  double Score(const Eigen::Vector3d& translation);
  double Split(const Eigen::Vector3d& translation);
  bool IsFree(const Eigen::Vector3d& point) const;
  void Remember(double score);

  const ScanModel& target_;
  const ScanModel& source_;
  const HypothesisOptions& options_;
  std::vector<Sample> samples_;
  // The samples' order: first those at whose places a surface may be, open_ of them.
  std::vector<std::uint32_t> order_;
  std::size_t open_ = 0;
  std::vector<Candidate> all_;
  // The scores of the best so far, the least on top.
  std::priority_queue<double, std::vector<double>, std::greater<>> best_;
  double least_ = -1e9;
};

}  // namespace planegraph
