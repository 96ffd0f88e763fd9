#pragma once

#include <vector>

#include "planegraph/correspondence/map_model.h"
#include "planegraph/correspondence/scan_group.h"

namespace planegraph {

/// Log of the odds of a pose over another one, nats.
struct PoseOdds {
  double all = 0.0;   ///< by all surfaces
  double lead = 0.0;  ///< and where the best wall may be another one: no more than that
};

/// Compares a pose of a group with others beside it by what the map says of its surfaces at both.
///
/// Nine surfaces in ten are confirmed at the right pose and contradicted at a wrong one (as
/// everywhere in the evidence): each is worth log 9. One that is confirmed lies within the noise
/// there, nine times in ten, and anywhere in the gate at a wrong pose: the ratio of the densities
/// of its height counts, too. What the map says alike at both poses does not tell them apart. Of
/// the rest, what lies in one block is one observation, and they count by their own weights (Kish's
/// effective number), however much there is of all else.
///
/// One time in ten all of a wall errs together: it may be another one, or be seen from its other
/// side, as no ground or roof is, which drone and robot both see from above. So the best of the
/// walls, all that lies in one plane, is worth no more than log 9, however long it is and however
/// well it fits; its height is what the pose was fitted to. A pose that a single wall holds in some
/// direction has a rival there.
class PoseRivals {
 public:
  /// `gate`: metres along the normal, `sigma`: metres, of the height of a surface over the map's.
  /// The map must outlive it.
  PoseRivals(const MapModel& map, const ScanGroup& group, const Sim3& found, double gate,
             double sigma);

  /// Of the pose that was found over the best of those that are `offset` away (map's axes, metres),
  /// or up to `slack` metres more or less.
  PoseOdds Compare(const Eigen::Vector3d& offset, double slack) const;

 private:
  struct Answer {
    double nats;           // for the pose and against one that has nothing to do with the truth
    double height;         // metres, where it is confirmed
    double slope;          // of the height along the unit offset
    bool confirmed, open;  // open: the map says nothing
  };
  // A surface of which the map does not say the same at both poses.
  struct Divider {
    double nats = 0.0, weight = 0.0;
  };
  // Over such surfaces; `squares` of the blocks' weights.
  struct Sums {
    double nats = 0.0, weight = 0.0, squares = 0.0;
    // Mean over the weights, times the number of blocks that they stand for.
    double Lead() const { return squares > 1e-12 ? nats * weight / squares : 0.0; }
  };

  std::vector<Answer> Ask(const Sim3& map_from_group, const Eigen::Vector3d& along) const;
  double HeightRatio(double height) const;
  PoseOdds Odds(const std::vector<Divider>& dividers) const;
  Sums Without(const std::vector<std::size_t>& wall, const std::vector<Divider>& dividers,
               const std::vector<double>& weights, Sums rest) const;
  void FindWalls();
  void FindBlocks();

  const MapModel& map_;
  Sim3 pose_;
  double gate_, sigma_;
  std::vector<GroupSample> samples_;
  std::vector<std::size_t> block_;               // by sample, from 0 on
  std::vector<std::vector<std::size_t>> walls_;  // samples that lie in one plane, by block
  std::size_t blocks_ = 0;
  std::vector<Answer> found_;
};

}  // namespace planegraph
