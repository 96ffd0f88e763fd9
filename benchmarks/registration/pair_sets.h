#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "planegraph/geometry/rigid3.h"
#include "planegraph/segmentation/plane_segment.h"

namespace planegraph {

/// The scans of a set whose consecutive pairs are registered without a guess, with their reference.
struct PairSet {
  std::string name;
  std::vector<PlaneSet> planes;   ///< by scan
  std::vector<Rigid3> reference;  ///< of the scans, in one frame
  double metres, degrees;         ///< a result farther from the reference is wrong
  bool last_to_first = false;     ///< that pair is one, too

  /// Source and target: every scan and the one before it, then the last and the first.
  std::vector<std::pair<std::size_t, std::size_t>> Pairs() const;
  /// Of the reference.
  Rigid3 TargetFromSource(std::size_t target, std::size_t source) const {
    return reference[target].Inverse() * reference[source];
  }
  std::string PairName(std::size_t source, std::size_t target) const;
};

/// pair_kitti, hybrid-site-a, bedkowski_tls13 and 3dtk_dat of the folder with the data sets.
std::vector<PairSet> ReadPairSets(const std::string& data);

}  // namespace planegraph
