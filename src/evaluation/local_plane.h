#pragma once

#include <cstdint>
#include <vector>

#include "evaluation/radius_grid.h"

namespace planegraph {

/// Mean of the largest quarter of the distances of a neighbourhood's points to its robust plane.
class PlaneVariance {
 public:
  /// `as_tool`: judges the planes on all points and divides as Razlaw's tool does.
  PlaneVariance(const RadiusGrid& grid, std::uint64_t seed, bool as_tool);
  /// Metres; negative where no plane is found.
  double operator()(const Neighbourhood& neighbourhood);

 private:
  struct Hypothesis {
    float normal[3];
    float distance;
    std::size_t inliers;
  };
  void TakeSample(const Neighbourhood& neighbourhood);
  Hypothesis Propose(std::uint64_t* state) const;
  std::size_t CountInliers(const Hypothesis& plane) const;
  Hypothesis BestOfSample(const Neighbourhood& neighbourhood) const;
  Hypothesis Refine(const Hypothesis& plane) const;
  void Measure(const Neighbourhood& neighbourhood, const Hypothesis& plane);
  double MeanOfLargestQuarter();
  double SumOfLargest(std::size_t largest);
  double SumFrom(float low, std::size_t count) const;

  const RadiusGrid& grid_;
  std::uint64_t seed_;
  bool as_tool_;
  std::vector<float> x_, y_, z_;  ///< the sample, relative to the centre
  std::vector<float> distances_, edge_;
  std::vector<std::uint32_t> bins_;
};

}  // namespace planegraph
