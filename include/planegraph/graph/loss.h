#pragma once

#include <ceres/loss_function.h>

#include <memory>
#include <string>
#include <vector>

namespace planegraph {

/// A robust loss by name. The scale is in sigmas of the whitened residual's norm.
struct LossSpec {
  std::string name = "none";
  double scale = 0.0;  ///< > 0, or 0 for the loss's default

  std::string ToString() const;  ///< NAME or NAME:SCALE
};

/// Reads NAME or NAME:SCALE. Throws UsageError for an unknown name or a scale that is not positive.
LossSpec ParseLoss(const std::string& text);

/// Null for "none".
std::unique_ptr<ceres::LossFunction> MakeLoss(const LossSpec& spec);

/// Names that ParseLoss takes: none, huber, soft_l1, cauchy, tukey, geman_mcclure, dcs.
const std::vector<std::string>& LossNames();

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
