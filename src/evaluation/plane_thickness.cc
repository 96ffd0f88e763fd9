#include "planegraph/evaluation/plane_thickness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "planegraph/base/disjoint_sets.h"
#include "planegraph/base/median.h"
#include "planegraph/geometry/moments.h"

namespace planegraph {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

using Cell = std::array<std::int64_t, 3>;
using Surface = std::tuple<std::uint8_t, std::int32_t, std::int32_t>;  // vision, scan, plane

// A plane's points in one cell.
struct Piece {
  Cell cell;
  std::size_t surface;
  Moments moments;
};

// Root mean square distance of points to a plane, squared, times their number; from moments alone.
double SquaresTo(const Moments& points, const Eigen::Vector3d& normal, const Eigen::Vector3d& at) {
  const double height = normal.dot(points.mean - at);
  return normal.dot(points.scatter * normal) + points.count * height * height;
}

// The normal of a piece, and nothing where it has no width to tell it.
std::optional<Eigen::Vector3d> NormalOf(const Moments& moments) {
  const PrincipalAxes axes = ComputePrincipalAxes(moments.scatter);
  constexpr double kLeastRatio = 10.0;  // of the variances in and across the plane
  if (!(axes.values[1] > kLeastRatio * axes.values[0])) return {};
  return axes.vectors.col(0);
}

bool Agree(const Moments& a, const Moments& b, double cosine, double gate) {
  const auto normal_a = NormalOf(a), normal_b = NormalOf(b);
  if (!normal_a || !normal_b || std::abs(normal_a->dot(*normal_b)) < cosine) return false;
  const Eigen::Vector3d between = b.mean - a.mean;
  return std::abs(normal_a->dot(between)) < gate && std::abs(normal_b->dot(between)) < gate;
}

void Accumulate(double squares, double points, ThicknessSum* sum) {
  sum->squares += squares;
  sum->points += points;
}

class ThicknessMeasure {
 public:
  ThicknessMeasure(const LabelledCloud& map, const PlaneThicknessOptions& options)
      : options_(options) {
    CollectPieces(map);
  }
  std::vector<LandmarkThickness> Run();

 private:
  using Pieces = std::vector<Piece>;
  void CollectPieces(const LabelledCloud& map);
  bool IsVision(const Piece& piece) const { return std::get<0>(surfaces_[piece.surface]) != 0; }
  std::int32_t ScanOf(const Piece& piece) const { return std::get<1>(surfaces_[piece.surface]); }
  std::size_t CellEnd(std::size_t first) const;
  void JoinInCell(std::size_t first, std::size_t last, DisjointSets* sets) const;
  void MeasureCell(std::size_t first, std::size_t last, DisjointSets* sets);
  void MeasureLandmark(const std::vector<const Piece*>& laser, std::size_t first, std::size_t last,
                       LandmarkThickness* landmark) const;

  const PlaneThicknessOptions& options_;
  std::vector<Surface> surfaces_;  ///< ascending: the laser's come first
  Pieces pieces_;                  ///< by cell, then by surface
  std::map<std::size_t, LandmarkThickness> landmarks_;
  std::map<std::size_t, ThicknessSum> alone_, alone_within_;
};

void ThicknessMeasure::CollectPieces(const LabelledCloud& map) {
  std::map<std::pair<Cell, Surface>, Moments> moments;
  std::map<Surface, std::size_t> numbers;
  for (std::size_t i = 0; i < map.cloud.size(); ++i) {
    if (map.planes[i] < 0) continue;
    const Eigen::Vector3d point = map.cloud.points[i].cast<double>();
    Cell cell;
    for (int axis = 0; axis < 3; ++axis) {
      const double index = std::floor(point[axis] / options_.cell);
      cell[static_cast<std::size_t>(axis)] =
          static_cast<std::int64_t>(std::clamp(index, -1e15, 1e15));
    }
    const Surface surface(map.vision[i], map.scans[i], map.planes[i]);
    moments[{cell, surface}].Add(point);
    numbers[surface] = 0;
  }
  for (auto& [surface, number] : numbers) {
    number = surfaces_.size();
    surfaces_.push_back(surface);
  }
  for (const auto& [key, sum] : moments) {
    if (sum.count < options_.least_points) continue;
    pieces_.push_back({key.first, numbers[key.second], sum});
  }
}

std::size_t ThicknessMeasure::CellEnd(std::size_t first) const {
  std::size_t last = first;
  while (last < pieces_.size() && pieces_[last].cell == pieces_[first].cell) ++last;
  return last;
}

void ThicknessMeasure::JoinInCell(std::size_t first, std::size_t last, DisjointSets* sets) const {
  for (std::size_t a = first; a < last; ++a) {
    for (std::size_t b = a + 1; b < last; ++b) {
      const Piece &p = pieces_[a], &q = pieces_[b];
      if (IsVision(p) || IsVision(q)) continue;
      if (ScanOf(p) == ScanOf(q)) continue;
      if (Agree(p.moments, q.moments, options_.cosine, options_.gate)) {
        sets->Join(p.surface, q.surface);
      }
    }
  }
}

void ThicknessMeasure::MeasureLandmark(const std::vector<const Piece*>& laser, std::size_t first,
                                       std::size_t last, LandmarkThickness* landmark) const {
  Moments all;
  double within = 0.0;
  for (const Piece* piece : laser) {
    all.Merge(piece->moments);
    within += std::max(0.0, ComputePrincipalAxes(piece->moments.scatter).values[0]);
  }
  const PrincipalAxes axes = ComputePrincipalAxes(all.scatter);
  // In the order of surfaces, so of scans.
  if (ScanOf(*laser.front()) != ScanOf(*laser.back())) {
    Accumulate(std::max(0.0, axes.values[0]), all.count, &landmark->laser_on_laser);
    Accumulate(within, all.count, &landmark->within_scans);
  }
  for (std::size_t i = first; i < last; ++i) {
    const Piece& piece = pieces_[i];
    if (!IsVision(piece)) continue;
    if (!Agree(all, piece.moments, options_.map_cosine, options_.map_gate)) continue;
    Accumulate(SquaresTo(piece.moments, axes.vectors.col(0), all.mean), piece.moments.count,
               &landmark->map_on_laser);
  }
}

void ThicknessMeasure::MeasureCell(std::size_t first, std::size_t last, DisjointSets* sets) {
  std::map<std::size_t, std::vector<const Piece*>> by_landmark;
  for (std::size_t i = first; i < last; ++i) {
    if (!IsVision(pieces_[i])) by_landmark[sets->Find(pieces_[i].surface)].push_back(&pieces_[i]);
  }
  for (const auto& [root, laser] : by_landmark) {
    MeasureLandmark(laser, first, last, &landmarks_[root]);
    for (const Piece* piece : laser) {
      Accumulate(std::max(0.0, ComputePrincipalAxes(piece->moments.scatter).values[0]),
                 piece->moments.count, &alone_[root]);
    }
  }
}

std::vector<LandmarkThickness> ThicknessMeasure::Run() {
  DisjointSets sets(surfaces_.size());
  for (std::size_t i = 0; i < pieces_.size(); i = CellEnd(i)) JoinInCell(i, CellEnd(i), &sets);
  for (std::size_t i = 0; i < pieces_.size(); i = CellEnd(i)) MeasureCell(i, CellEnd(i), &sets);
  std::map<std::size_t, std::vector<std::int32_t>> scans;
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    if (std::get<0>(surfaces_[s]) != 0) break;
    scans[sets.Find(s)].push_back(std::get<1>(surfaces_[s]));
  }
  std::vector<LandmarkThickness> result;
  for (auto& [root, landmark] : landmarks_) {
    std::vector<std::int32_t>& seen = scans[root];
    landmark.scan = std::get<1>(surfaces_[root]);
    landmark.plane = std::get<2>(surfaces_[root]);
    landmark.scans = static_cast<std::size_t>(
        std::distance(seen.begin(), std::unique(seen.begin(), seen.end())));
    if (landmark.scans == 1) landmark.laser_on_laser = landmark.within_scans = alone_[root];
    result.push_back(landmark);
  }
  return result;
}

// The interval of a root mean square: of its square, landmarks being what is independent.
std::optional<Interval> RmsInterval(const std::vector<BlockSum>& blocks, double level) {
  auto interval = MeanInterval(blocks, level);
  if (interval) {
    *interval = {std::sqrt(std::max(0.0, interval->low)), std::sqrt(std::max(0.0, interval->high))};
  }
  return interval;
}

}  // namespace

double ThicknessSum::Rms() const { return points > 0.0 ? std::sqrt(squares / points) : kNone; }

PlaneThickness ComputePlaneThickness(const LabelledCloud& map, const PlaneThicknessOptions& options,
                                     double level) {
  PlaneThickness result;
  result.landmarks = ThicknessMeasure(map, options).Run();
  std::vector<BlockSum> laser, vision;
  std::vector<double> laser_thickness, map_thickness;
  for (const LandmarkThickness& landmark : result.landmarks) {
    const ThicknessSum& own = landmark.laser_on_laser;
    if (landmark.scans > 1 && own.points > 0.0) {
      Accumulate(own.squares, own.points, &result.laser_on_laser);
      Accumulate(landmark.within_scans.squares, landmark.within_scans.points, &result.within_scans);
      laser.push_back({own.squares, own.points});
      laser_thickness.push_back(own.Rms());
    }
    const ThicknessSum& seen = landmark.map_on_laser;
    if (seen.points == 0.0) continue;
    Accumulate(seen.squares, seen.points, &result.map_on_laser);
    vision.push_back({seen.squares, seen.points});
    map_thickness.push_back(seen.Rms());
  }
  result.laser_median = Median(std::move(laser_thickness), kNone);
  result.map_median = Median(std::move(map_thickness), kNone);
  result.laser_interval = RmsInterval(laser, level);
  result.map_interval = RmsInterval(vision, level);
  return result;
}

}  // namespace planegraph
