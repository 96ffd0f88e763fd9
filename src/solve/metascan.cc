#include "planegraph/solve/metascan.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <numbers>

#include "planegraph/base/error.h"
#include "planegraph/geometry/rotation.h"
#include "solve/metascan_map.h"

namespace planegraph {
namespace {

// What holds a pose along the directions that the planes leave open: metres, radians.
constexpr double kHoldTranslation = 1.0, kHoldRotation = 0.1;

// The gates close to these while a scan is registered: degrees, metres.
constexpr double kLeastAngleDeg = 1.5, kLeastOffset = 0.06;

class Metascan {
 public:
  Metascan(const std::vector<PlaneSet>& scans, const std::vector<Rigid3>& start,
           const MetascanOptions& options)
      : scans_(scans), options_(options), placed_(scans.size()) {
    result_.poses = start;
  }

  MetascanResult Run();

 private:
  void Join(std::size_t scan);
  void Place(std::size_t scan);
  std::vector<std::size_t> Neighbours(std::size_t scan, std::size_t joined) const;
  int CountOverlaps(std::size_t a, std::size_t b) const;
  bool Move(std::size_t scan, const std::vector<std::size_t>& neighbours);
  std::vector<PlaneMatch> Associate(const std::vector<WorldSegment>& current,
                                    std::vector<MetaSegment>* metascan, double shrink) const;
  bool Fixed(std::size_t scan) const;
  bool Changed(const Rigid3& before, const Rigid3& after) const;

  const std::vector<PlaneSet>& scans_;
  const MetascanOptions& options_;
  std::vector<std::vector<WorldSegment>> placed_;
  MetascanResult result_;
};

void Metascan::Place(std::size_t scan) {
  placed_[scan] = PlaceSegments(scans_[scan], result_.poses[scan], options_.min_area);
}

int Metascan::CountOverlaps(std::size_t a, std::size_t b) const {
  const CoincidenceGate gate(options_.max_angle_deg, options_.max_offset,
                             options_.overlap_tolerance);
  int count = 0;
  for (const WorldSegment& s : placed_[a]) {
    count += std::any_of(placed_[b].begin(), placed_[b].end(), [&](const WorldSegment& t) {
      return gate.Admits(s.normal, s.centroid, s.box, t);
    });
    if (count >= options_.least_overlaps) break;
  }
  return count;
}

std::vector<std::size_t> Metascan::Neighbours(std::size_t scan, std::size_t joined) const {
  std::vector<std::size_t> neighbours;
  for (std::size_t other = 0; other < joined; ++other) {
    if (other != scan && CountOverlaps(scan, other) >= options_.least_overlaps) {
      neighbours.push_back(other);
    }
  }
  return neighbours;
}

// Each surface of the current scan with the surface of the metascan that lies nearest along the
// normal; between equally near ones the more similar area decides.
std::vector<PlaneMatch> Metascan::Associate(const std::vector<WorldSegment>& current,
                                            std::vector<MetaSegment>* metascan,
                                            double shrink) const {
  const CoincidenceGate gate(std::max(kLeastAngleDeg, shrink * options_.max_angle_deg),
                             std::max(kLeastOffset, shrink * options_.max_offset),
                             options_.overlap_tolerance);
  std::vector<PlaneMatch> matches;
  for (const WorldSegment& s : current) {
    MetaSegment* best = nullptr;
    double best_distance = std::numeric_limits<double>::max();
    for (MetaSegment& meta : *metascan) {
      if (!gate.Admits(meta.normal, meta.moments.mean, meta.box, s)) continue;
      const double distance = std::abs(meta.normal.dot(s.centroid - meta.moments.mean));
      const bool close = best != nullptr && std::abs(distance - best_distance) < 0.02;
      const auto unlike = [&](MetaSegment& m) {
        return std::abs(std::log(m.Area() / s.segment->area));
      };
      if (close ? unlike(meta) < unlike(*best) : distance < best_distance) {
        best = &meta, best_distance = distance;
      }
    }
    if (best != nullptr) matches.push_back({best->plane, MakeFittedPlane(*s.segment)});
  }
  return matches;
}

bool Metascan::Fixed(std::size_t scan) const {
  return scan < options_.fixed.size() && options_.fixed[scan];
}

bool Metascan::Changed(const Rigid3& before, const Rigid3& after) const {
  return (before.translation - after.translation).norm() > options_.min_translation ||
         AngleBetween(before.rotation, after.rotation) >
             options_.min_rotation_deg * std::numbers::pi / 180.0;
}

bool Metascan::Move(std::size_t scan, const std::vector<std::size_t>& neighbours) {
  std::vector<const std::vector<WorldSegment>*> segments;
  for (const std::size_t n : neighbours) segments.push_back(&placed_[n]);
  auto metascan = MergeSegments(
      segments, CoincidenceGate(options_.group_angle_deg, options_.group_offset, 0.5));
  const Rigid3 before = result_.poses[scan];
  ClosedFormOptions closed_form;
  closed_form.open = OpenDirections::kProjection;
  for (int k = 0; k < options_.max_iterations; ++k) {
    const Rigid3 last = result_.poses[scan];
    const auto matches = Associate(placed_[scan], &metascan, std::pow(0.5, k));
    if (static_cast<int>(matches.size()) < options_.least_overlaps) break;
    PosePrior hold{last, Matrix6d::Identity() * kHoldTranslation * kHoldTranslation};
    hold.covariance.bottomRightCorner<3, 3>() *= std::pow(kHoldRotation / kHoldTranslation, 2);
    result_.poses[scan] = SolveClosedForm(matches, closed_form, hold).target_from_source;
    Place(scan);
    if (k > 2 && !Changed(last, result_.poses[scan])) break;
  }
  return Changed(before, result_.poses[scan]);
}

void Metascan::Join(std::size_t scan) {
  Place(scan);
  std::deque<std::size_t> queue = {scan};
  const std::size_t joined = scan + 1;
  const std::size_t most = static_cast<std::size_t>(options_.most_pops_per_scan) * scans_.size();
  while (!queue.empty()) {
    if (result_.pops >= most) {
      result_.terminated = false;
      return;
    }
    result_.pops++;
    const std::size_t current = queue.front();
    queue.pop_front();
    if (current == 0 || Fixed(current)) continue;
    const auto neighbours = Neighbours(current, joined);
    if (neighbours.empty()) {
      if (current == scan) result_.alone.push_back(scan);
      continue;
    }
    if (!Move(current, neighbours)) continue;
    for (const std::size_t n : neighbours) {
      if (std::find(queue.begin(), queue.end(), n) == queue.end()) queue.push_back(n);
    }
  }
}

MetascanResult Metascan::Run() {
  const std::vector<Rigid3> start = result_.poses;
  if (!scans_.empty()) Place(0);
  for (std::size_t scan = 1; scan < scans_.size(); ++scan) {
    if (Fixed(scan)) {
      Place(scan);
      continue;
    }
    result_.poses[scan] = result_.poses[scan - 1] * (start[scan - 1].Inverse() * start[scan]);
    Join(scan);
  }
  return std::move(result_);
}

}  // namespace

MetascanResult OptimizeMetascan(const std::vector<PlaneSet>& scans,
                                const std::vector<Rigid3>& start, const MetascanOptions& options) {
  if (scans.size() != start.size()) {
    throw UsageError("metascan: " + std::to_string(scans.size()) + " scans, but " +
                     std::to_string(start.size()) + " poses");
  }
  return Metascan(scans, start, options).Run();
}

}  // namespace planegraph
