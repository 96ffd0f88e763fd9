#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/trajectory_error.h"

namespace planegraph {
namespace {

MatrixPose PoseAt(const Trajectory& trajectory, std::size_t i) {
  const Rigid3& pose = trajectory.poses[i];
  const bool as_read = trajectory.matrices.size() == trajectory.size();
  return {as_read ? trajectory.matrices[i] : pose.rotation.toRotationMatrix(), pose.translation};
}

void Append(const Trajectory& reference, std::size_t i, const Trajectory& estimate, std::size_t j,
            PosePairs* pairs) {
  pairs->indices.push_back(i);
  pairs->estimate_indices.push_back(j);
  pairs->times.push_back(reference.times[i]);
  pairs->reference.push_back(PoseAt(reference, i));
  pairs->estimate.push_back(PoseAt(estimate, j));
}

// Indices into times, in the order of time: files are mostly sorted, but nothing demands it.
std::vector<std::size_t> SortedByTime(const std::vector<double>& times) {
  std::vector<std::size_t> order(times.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return times[a] < times[b]; });
  return order;
}

// The index of the time nearest to `time`; of two equally near ones the earlier.
std::size_t NearestInTime(const std::vector<double>& times, const std::vector<std::size_t>& order,
                          double time) {
  const auto after = std::lower_bound(order.begin(), order.end(), time,
                                      [&](std::size_t i, double t) { return times[i] < t; });
  if (after == order.begin()) return *after;
  const std::size_t before = *(after - 1);
  if (after == order.end()) return before;
  return time - times[before] <= times[*after] - time ? before : *after;
}

PosePairs PairByTime(const Trajectory& reference, const Trajectory& estimate,
                     double max_difference) {
  PosePairs pairs;
  const bool reference_is_short = reference.size() < estimate.size();
  const Trajectory& few = reference_is_short ? reference : estimate;
  const Trajectory& many = reference_is_short ? estimate : reference;
  if (few.size() == 0) return pairs;
  const std::vector<std::size_t> order = SortedByTime(many.times);
  for (std::size_t i = 0; i < few.size(); ++i) {
    const std::size_t j = NearestInTime(many.times, order, few.times[i]);
    const double difference = std::abs(many.times[j] - few.times[i]);
    if (difference > max_difference) {
      ++pairs.unpaired;
      continue;
    }
    Append(reference, reference_is_short ? i : j, estimate, reference_is_short ? j : i, &pairs);
    pairs.max_time_difference = std::max(pairs.max_time_difference, difference);
  }
  return pairs;
}

PosePairs PairByIndex(const Trajectory& reference, const Trajectory& estimate,
                      const std::string& estimate_name) {
  if (reference.size() != estimate.size()) {
    throw InputError::InFile(estimate_name, "has " + std::to_string(estimate.size()) +
                                                " poses and the reference " +
                                                std::to_string(reference.size()) +
                                                "; without times on both the counts must be equal");
  }
  PosePairs pairs;
  pairs.by_time = false;
  for (std::size_t i = 0; i < reference.size(); ++i) Append(reference, i, estimate, i, &pairs);
  return pairs;
}

std::vector<std::pair<std::size_t, std::size_t>> DisjointPairs(
    const std::vector<std::size_t>& stops) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t k = 1; k < stops.size(); ++k) pairs.emplace_back(stops[k - 1], stops[k]);
  return pairs;
}

std::vector<std::pair<std::size_t, std::size_t>> PairsByFrames(std::size_t count,
                                                               const RpeOptions& options) {
  const auto delta = static_cast<std::size_t>(options.delta);
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const std::size_t step = options.all_pairs ? 1 : delta;
  for (std::size_t i = 0; i + delta < count; i += step) pairs.emplace_back(i, i + delta);
  return pairs;
}

// Length of the path from pose 0 to each pose.
std::vector<double> PathLengths(const std::vector<MatrixPose>& poses) {
  std::vector<double> lengths(poses.size(), 0.0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    lengths[i] = lengths[i - 1] + (poses[i].translation - poses[i - 1].translation).norm();
  }
  return lengths;
}

std::vector<std::pair<std::size_t, std::size_t>> DisjointPairsByPath(
    const std::vector<MatrixPose>& poses, double delta) {
  std::vector<std::size_t> stops;
  double path = 0.0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    path += (poses[i].translation - poses[i - 1].translation).norm();
    if (path < delta) continue;
    stops.push_back(i);
    path = 0.0;
  }
  return DisjointPairs(stops);
}

std::vector<std::pair<std::size_t, std::size_t>> AllPairsByPath(
    const std::vector<MatrixPose>& poses, double delta, double tolerance) {
  const std::vector<double> lengths = PathLengths(poses);
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i + 1 < lengths.size(); ++i) {
    const double wanted = lengths[i] + delta;
    const auto first = lengths.begin() + static_cast<std::ptrdiff_t>(i) + 1;
    auto best = std::lower_bound(first, lengths.end(), wanted);
    if (best == lengths.end() || (best != first && wanted - *(best - 1) <= *best - wanted)) --best;
    // Of poses that stand still the first is meant.
    best = std::lower_bound(first, lengths.end(), *best);
    if (std::abs(*best - wanted) > tolerance) continue;
    pairs.emplace_back(i, static_cast<std::size_t>(best - lengths.begin()));
  }
  return pairs;
}

void CheckDelta(const RpeOptions& options) {
  const bool whole = options.delta == std::floor(options.delta);
  if (!(options.delta > 0.0) || !std::isfinite(options.delta)) {
    throw UsageError("delta must be above 0");
  }
  if (options.unit == DeltaUnit::kFrames && !whole) {
    throw UsageError("delta must be a whole number of frames");
  }
}

}  // namespace

PosePairs PairPoses(const Trajectory& reference, const Trajectory& estimate, double max_difference,
                    const std::string& estimate_name) {
  if (!reference.has_times || !estimate.has_times) {
    return PairByIndex(reference, estimate, estimate_name);
  }
  PosePairs pairs = PairByTime(reference, estimate, max_difference);
  if (pairs.reference.empty()) {
    throw NoResultError("no pose of the estimate lies within " + std::to_string(max_difference) +
                        " s of one of the reference");
  }
  return pairs;
}

std::vector<std::pair<std::size_t, std::size_t>> SelectPairs(const std::vector<MatrixPose>& poses,
                                                             const RpeOptions& options) {
  CheckDelta(options);
  if (options.unit == DeltaUnit::kFrames) return PairsByFrames(poses.size(), options);
  if (!options.all_pairs) return DisjointPairsByPath(poses, options.delta);
  return AllPairsByPath(poses, options.delta, options.relative_tolerance * options.delta);
}

}  // namespace planegraph
