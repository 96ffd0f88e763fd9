#include "planegraph/graph/loss.h"

#include <cmath>
#include <map>
#include <sstream>

#include "planegraph/base/chi_square.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

// Defaults: 95 % efficiency for Huber and Tukey, 2.4 for Cauchy; 2.8^2 = 7.8 is the 95 % quantile
// of chi-square with the three degrees of freedom of a plane observation.
const std::map<std::string, double>& DefaultScales() {
  static const std::map<std::string, double> scales =
      {{"none", 0.0},    {"huber", 1.345},       {"soft_l1", 1.0}, {"cauchy", 2.4},
       {"tukey", 4.685}, {"geman_mcclure", 2.8}, {"dcs", 2.8},     {"gnc_tls", 0.0},
       {"gnc_gm", 0.0}};  // these by the residual's dimension: GraduatedThreshold
  return scales;
}

double ParseScale(const std::string& text) {
  std::istringstream stream(text);
  double scale = 0.0;
  stream >> scale;
  if (stream.fail() || !stream.eof() || !std::isfinite(scale) || scale <= 0.0) {
    throw UsageError("the scale of a loss must be a positive number, not '" + text + "'");
  }
  return scale;
}

}  // namespace

std::string LossSpec::ToString() const {
  if (scale <= 0.0) return name;
  std::ostringstream stream;
  stream << name << ':' << scale;
  return stream.str();
}

const std::vector<std::string>& LossNames() {
  static const std::vector<std::string> names = {
      "none", "huber", "soft_l1", "cauchy", "tukey", "geman_mcclure", "dcs", "gnc_tls", "gnc_gm"};
  return names;
}

namespace {

[[noreturn]] void FailUnknown(const std::string& name) {
  std::string known;
  for (const std::string& loss : LossNames()) known += (known.empty() ? "" : ", ") + loss;
  throw UsageError("unknown loss '" + name + "' (" + known + ")");
}

}  // namespace

LossSpec ParseLoss(const std::string& text) {
  const std::size_t colon = text.find(':');
  LossSpec spec{text.substr(0, colon), 0.0};
  if (spec.name == "soft_l_one") spec.name = "soft_l1";  // as Ceres spells it
  if (!DefaultScales().count(spec.name)) FailUnknown(spec.name);
  if (colon == std::string::npos) return spec;
  if (spec.name == "none") throw UsageError("the loss 'none' has no scale");
  spec.scale = ParseScale(text.substr(colon + 1));
  return spec;
}

std::unique_ptr<ceres::LossFunction> MakeLoss(const LossSpec& spec) {
  const auto known = DefaultScales().find(spec.name);
  if (known == DefaultScales().end()) FailUnknown(spec.name);
  const double scale = spec.scale > 0.0 ? spec.scale : known->second;
  if (spec.name == "huber") return std::make_unique<ceres::HuberLoss>(scale);
  if (spec.name == "soft_l1") return std::make_unique<ceres::SoftLOneLoss>(scale);
  if (spec.name == "cauchy") return std::make_unique<ceres::CauchyLoss>(scale);
  if (spec.name == "tukey") return std::make_unique<ceres::TukeyLoss>(scale);
  if (spec.name == "geman_mcclure") return std::make_unique<GemanMcClureLoss>(scale);
  if (spec.name == "dcs") return std::make_unique<DcsLoss>(scale);
  return nullptr;
}

bool IsGraduated(const LossSpec& spec) { return spec.name == "gnc_tls" || spec.name == "gnc_gm"; }

GncKernel KernelOf(const LossSpec& spec) {
  return spec.name == "gnc_gm" ? GncKernel::kGemanMcClure : GncKernel::kTruncated;
}

double GraduatedThreshold(const LossSpec& spec, int dimension) {
  if (spec.scale > 0.0) return spec.scale * spec.scale;
  return ChiSquareQuantile(0.99, dimension);
}

void GemanMcClureLoss::Evaluate(double s, double rho[3]) const {
  const double inverse = 1.0 / (c2_ + s);
  rho[0] = c2_ * s * inverse;
  rho[1] = c2_ * c2_ * inverse * inverse;
  rho[2] = -2.0 * rho[1] * inverse;
}

void DcsLoss::Evaluate(double s, double rho[3]) const {
  if (s <= phi_) {
    rho[0] = s, rho[1] = 1.0, rho[2] = 0.0;
    return;
  }
  const double inverse = 1.0 / (phi_ + s);
  rho[0] = phi_ * (3.0 * s - phi_) * inverse;
  rho[1] = 4.0 * phi_ * phi_ * inverse * inverse;
  rho[2] = -2.0 * rho[1] * inverse;
}

}  // namespace planegraph
