#pragma once

#include <vector>

namespace planegraph {

/// Graduated non-convexity (Yang, Antonante, Tzoumas, Carlone 2020; ALGORITHMS 6.8): a robust cost
/// is reached over a sequence of easier ones. Each step solves a weighted least-squares problem,
/// then takes new weights from the residuals in closed form; mu makes the surrogate less and less
/// convex. No start near the solution is needed, as the first surrogate is nearly quadratic.
enum class GncKernel {
  kTruncated,     ///< truncated least squares: min(s, c^2); the weights end at 0 or 1
  kGemanMcClure,  ///< c^2 s / (c^2 + s)
};

/// The schedule of one run. All chi2 are squared norms |r|^2 of whitened residuals, without the
/// weight; the cost of a residual in the weighted problem is weight * |r|^2 / 2.
///
///   GncSchedule schedule(GncKernel::kTruncated, 2.8);
///   schedule.Start(chi2);               // of the unweighted solution
///   while (!schedule.Finished()) {
///     for (k...) weight[k] = schedule.Weight(chi2[k]);
///     chi2 = SolveWeighted(weight);
///     schedule.Advance(chi2);
///   }
///   for (k...) weight[k] = schedule.FinalWeight(chi2[k]);
class GncSchedule {
 public:
  /// `scale`: c > 0, in sigmas of the residual's norm: the largest norm of an inlier. `factor` > 1:
  /// how fast the surrogate hardens.
  GncSchedule(GncKernel kernel, double scale, double factor = 1.4);

  /// Chooses the first surrogate, convex for the largest of the residuals. Finished at once where
  /// all of them are inliers anyway.
  void Start(const std::vector<double>& chi2);
  /// The weight under the present surrogate, in [0, 1], not increasing in chi2.
  double Weight(double chi2) const;
  /// Takes the next surrogate. Finished where it is the robust cost itself or (truncated) where all
  /// weights are 0 or 1.
  void Advance(const std::vector<double>& chi2);
  bool Finished() const { return finished_; }
  /// The weight under the robust cost itself.
  double FinalWeight(double chi2) const;
  double mu() const { return mu_; }

 private:
  bool AllBinary(const std::vector<double>& chi2) const;

  GncKernel kernel_;
  double c2_, factor_, mu_ = 1.0;
  bool finished_ = false;
};

}  // namespace planegraph
