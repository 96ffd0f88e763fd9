#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planegraph/cloud/cloud.h"
#include "planegraph/evaluation/interval.h"

namespace planegraph {

/// How neighbourhoods that give no figure are counted.
enum class MapQualityMode {
  kClean,  ///< they are left out
  kTool    ///< as the tool of Razlaw et al. does: they add 0 and count in the denominator
};
/// "clean", "tool". Throws UsageError for another name.
MapQualityMode ParseMapQualityMode(const std::string& name);
std::string Name(MapQualityMode mode);

struct MapQualityOptions {
  double radius = 0.3;    ///< of the neighbourhoods, metres
  std::size_t every = 1;  ///< every k-th point, in the cloud's order, is asked for its neighbours
  std::size_t min_neighbours = 15;  ///< least points of a neighbourhood (kClean only)
  MapQualityMode mode = MapQualityMode::kClean;
  bool plane_variance = true;  ///< MPV takes most of the time
  bool keep_values = false;    ///< fills MapQuality::values
  std::uint64_t seed = 0;      ///< of MPV's plane hypotheses
  int threads = 0;             ///< 0: all cores; no figure depends on it
};

/// What one point's neighbourhood gives; NaN where it gives nothing.
struct PointQuality {
  float entropy, plane_variance, thickness;  ///< nats, metres, metres
};

/// Sharpness of a cloud; smaller is sharper for all three. They depend on the density: compare
/// equal sets of points with equal radii, never a filtered cloud with a raw one, and no scales.
struct MapQuality {
  /// Mean map entropy, nats: the mean of 0.5 ln det(2 pi e Sigma).
  double mme = 0.0;
  /// "Mean plane variance", metres (a distance by its making): the mean over the neighbourhoods of
  /// the mean of the largest quarter of the distances to a robust plane; 0 where not asked for.
  double mpv = 0.0;
  /// Square root of the smallest eigenvalue of Sigma, metres, over the used neighbourhoods.
  double thickness_mean = 0.0, thickness_median = 0.0;
  std::size_t points = 0;     ///< in the cloud
  std::size_t evaluated = 0;  ///< asked for their neighbours: used + failed
  std::size_t used = 0;
  /// kClean: fewer than min_neighbours points, or no spread in some direction (below a micrometre).
  /// kTool: a covariance whose determinant is not positive.
  std::size_t failed = 0;
  /// Of the used ones, those without a plane for MPV (fewer than four points, or no three within 5
  /// mm of a plane): kClean leaves them out of it, kTool counts 0.
  std::size_t mpv_failed = 0;
  std::vector<PointQuality> values;  ///< one per point, in the cloud's order; see keep_values
};

/// MME and MPV after Razlaw et al. 2015 ("Evaluation of registration methods for sparse 3D laser
/// scans"), and local thickness. The neighbourhood of a point is the closed ball around it, itself
/// included; Sigma is its covariance divided by N. All neighbours count, no matter how many: whole
/// cells inside the ball enter by their stored moments, exactly.
///
/// MPV's plane: the best of at most 50 planes through three points (inliers within 5 mm, the number
/// adapted for 99 % confidence), then least squares on its inliers. kClean judges on up to 512
/// points spread over the neighbourhood, kTool on all, several times slower; kTool also divides the
/// sum of the distances from the (3 floor(N/4))-th on by floor(N/4) as the tool does. The random
/// numbers follow from the seed and the point's index, so the figures repeat.
///
/// Throws UsageError for a radius that is not positive or too small for the cloud's extent, and
/// NoResultError where no neighbourhood gives a figure.
MapQuality ComputeMapQuality(const Cloud& cloud, const MapQualityOptions& options);

/// Intervals of the means over space: what is independent are the cubes of ten radii' edge that the
/// points fall into, for near points share their neighbours. Nothing where there are fewer than
/// kLeastBlocks cubes, and in kTool, whose means are none. `values` of MapQuality are needed.
struct MapQualityIntervals {
  std::optional<Interval> mme, mpv, thickness_mean;
  std::size_t blocks = 0;
};
MapQualityIntervals ComputeIntervals(const Cloud& cloud, const MapQuality& quality,
                                     const MapQualityOptions& options, double level);

/// Mean differences `b` less `a` of two clouds of the same points, over those points that are used
/// in both; negative: b is sharper. Cubes as above, in cloud a. Throws UsageError for clouds of
/// unequal sizes and NoResultError where no point is used in both.
struct MapQualityDifference {
  double mme = 0.0, mpv = 0.0, thickness_mean = 0.0;
  MapQualityIntervals intervals;
  std::size_t points = 0;  ///< used in both
};
MapQualityDifference CompareQuality(const Cloud& cloud_a, const MapQuality& a, const MapQuality& b,
                                    const MapQualityOptions& options, double level);

}  // namespace planegraph
