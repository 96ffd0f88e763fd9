#pragma once

#include <ceres/loss_function.h>

#include <memory>
#include <string>
#include <vector>

#include "planegraph/graph/gnc.h"

namespace planegraph {

/// A robust loss by name. The scale is in sigmas of the whitened residual's norm.
struct LossSpec {
  std::string name = "none";
  double scale = 0.0;  ///< > 0, or 0 for the loss's default

  std::string ToString() const;  ///< NAME or NAME:SCALE
};

/// Reads NAME or NAME:SCALE. Throws UsageError for an unknown name or a scale that is not positive.
LossSpec ParseLoss(const std::string& text);

/// Null for "none" and for the graduated ones, which are no function of one residual.
std::unique_ptr<ceres::LossFunction> MakeLoss(const LossSpec& spec);

/// Names that ParseLoss takes: none, huber, soft_l1, cauchy, tukey, geman_mcclure, dcs, and by
/// graduated non-convexity gnc_tls (truncated least squares) and gnc_gm (Geman-McClure).
const std::vector<std::string>& LossNames();

/// Whether the loss is reached by graduated non-convexity, in an outer loop around the solver.
bool IsGraduated(const LossSpec& spec);
/// The kernel of a graduated loss.
GncKernel KernelOf(const LossSpec& spec);
/// c^2 of a graduated loss for a residual of that many dimensions: the scale's square, or by
/// default the 99 % quantile of chi-square.
double GraduatedThreshold(const LossSpec& spec, int dimension);

/// A weight that the outer loop sets: rho(s) = weight * s.
class WeightLoss final : public ceres::LossFunction {
 public:
  explicit WeightLoss(double weight) : weight_(weight) {}
  void Set(double weight) { weight_ = weight; }
  void Evaluate(double s, double rho[3]) const override {
    rho[0] = weight_ * s, rho[1] = weight_, rho[2] = 0.0;
  }

 private:
  double weight_;
};

/// Geman-McClure: rho(s) = c^2 s / (c^2 + s).
class GemanMcClureLoss final : public ceres::LossFunction {
 public:
  explicit GemanMcClureLoss(double c) : c2_(c * c) {}
  void Evaluate(double s, double rho[3]) const override;

 private:
  double c2_;
};

/// Dynamic covariance scaling (Agarwal et al. 2013): rho(s) = s up to phi = c^2, then
/// phi (3 s - phi) / (s + phi), whose derivative is the method's squared weight.
class DcsLoss final : public ceres::LossFunction {
 public:
  explicit DcsLoss(double c) : phi_(c * c) {}
  void Evaluate(double s, double rho[3]) const override;

 private:
  double phi_;
};

}  // namespace planegraph
