// register_table DATA: registers every pair of the data sets without a guess and prints the errors
// as a Markdown table (docs/registration.md), and for each run how well three scans close. DATA is
// the folder with the sets.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "planegraph/base/angles.h"
#include "planegraph/geometry/rotation.h"
#include "planegraph/registration/registration.h"
#include "registration/pair_sets.h"
#include "report_errors.h"

namespace planegraph {
namespace {

struct Tally {
  int pairs = 0, ok = 0, wrong = 0, inside = 0;
  std::string closures;
};

// Largest error of a component in standard deviations.
double WorstSigmas(const Rigid3& found, const Rigid3& truth, const Matrix6d& covariance) {
  Eigen::Matrix<double, 6, 1> error;
  error << found.translation - truth.translation,
      LogSO3(found.rotation * truth.rotation.conjugate());
  return (error.array().abs() / covariance.diagonal().array().sqrt()).maxCoeff();
}

Registration Report(const PairSet& set, std::size_t source, std::size_t target, Tally* tally) {
  Registration result = Register(ScanModel(set.planes[target]), ScanModel(set.planes[source]));
  const Rigid3 truth = set.TargetFromSource(target, source);
  const Rigid3& found = result.target_from_source();
  const double metres = (found.translation - truth.translation).norm();
  const double degrees = AngleBetween(found.rotation, truth.rotation) / kDegree;
  const Matrix6d& covariance = result.refinement.covariance;
  const double sigmas = WorstSigmas(found, truth, covariance);
  const bool ok = result.status == RegistrationStatus::kOk;
  const bool wrong = ok && (metres > set.metres || degrees > set.degrees);
  tally->pairs++, tally->ok += ok, tally->wrong += wrong, tally->inside += sigmas <= 3.0;
  const auto three_sigma = [&](int first) {
    return 3.0 * std::sqrt(covariance.diagonal().segment<3>(first).maxCoeff());
  };
  std::printf("| %s | %s%s | %.3f | %.3f | %.3f | %.3f | %.1f | %.2f / %.2f | %s |\n",
              set.PairName(source, target).c_str(), ToString(result.status),
              wrong ? " (WRONG)" : "", metres, degrees, three_sigma(0), three_sigma(3) / kDegree,
              sigmas, result.quality, result.runner_up, result.reason.c_str());
  std::fflush(stdout);
  return result;
}

// ---- closure: the covariances checked without any reference ----

struct PoseEstimate {
  Rigid3 pose;
  Matrix6d covariance;  // decoupled left perturbation
};

PoseEstimate EstimateOf(const Registration& registration) {
  return {registration.target_from_source(), registration.refinement.covariance};
}

PoseEstimate Chain(const PoseEstimate& a, const PoseEstimate& b) {
  const Eigen::Matrix3d rotation = a.pose.rotation.toRotationMatrix();
  Matrix6d by_a = Matrix6d::Identity(), by_b = Matrix6d::Zero();
  by_a.topRightCorner<3, 3>() = -Hat(rotation * b.pose.translation);
  by_b.topLeftCorner<3, 3>() = by_b.bottomRightCorner<3, 3>() = rotation;
  return {a.pose * b.pose,
          by_a * a.covariance * by_a.transpose() + by_b * b.covariance * by_b.transpose()};
}

bool IsOk(const Registration& r) { return r.status == RegistrationStatus::kOk; }

// Every scan against the one after the next, beside the chain of the two pairs between them.
std::string DescribeClosures(const std::string& name, const std::vector<PlaneSet>& planes,
                             const std::vector<Registration>& steps) {
  std::vector<double> worst;
  for (std::size_t k = 0; k + 1 < steps.size(); ++k) {
    if (!IsOk(steps[k]) || !IsOk(steps[k + 1])) continue;
    const PoseEstimate chain = Chain(EstimateOf(steps[k]), EstimateOf(steps[k + 1]));
    const Registration direct = RegisterFromGuess(ScanModel(planes[k]), ScanModel(planes[k + 2]),
                                                  {chain.pose, 1e4 * Matrix6d::Identity()});
    if (!IsOk(direct)) continue;
    worst.push_back(WorstSigmas(chain.pose, direct.target_from_source(),
                                chain.covariance + direct.refinement.covariance));
  }
  if (worst.empty()) return "";
  std::sort(worst.begin(), worst.end());
  char text[200];
  std::snprintf(text, sizeof(text), "| %s | %zu | %.1f | %.1f |\n", name.c_str(), worst.size(),
                worst[worst.size() / 2], worst.back());
  return text;
}

void ReportRun(const PairSet& set, Tally* tally) {
  std::vector<Registration> steps;
  for (const auto& [source, target] : set.Pairs()) {
    Registration found = Report(set, source, target, tally);
    if (source == target + 1) steps.push_back(std::move(found));
  }
  tally->closures += DescribeClosures(set.name, set.planes, steps);
}

int Run(const std::string& data) {
  Tally tally;
  std::puts(
      "| pair | status | error, m | error, deg | 3 sigma, m | 3 sigma, deg | worst error in "
      "sigmas | quality / runner-up | reason |\n|---|---|---|---|---|---|---|---|---|");
  for (const PairSet& set : ReadPairSets(data)) ReportRun(set, &tally);
  std::printf(
      "\n%d of %d pairs ok (%.0f %%), %d of them wrong; %d within 3 sigma in each component\n",
      tally.ok, tally.pairs, 100.0 * tally.ok / tally.pairs, tally.wrong, tally.inside);
  std::printf("\n| run | closures | median | largest |\n|---|---|---|---|\n%s",
              tally.closures.c_str());
  return tally.wrong == 0 ? 0 : 1;
}

}  // namespace
}  // namespace planegraph

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "register_table DATA\n"), 1;
  return planegraph::ReportErrors([&] { return planegraph::Run(argv[1]); });
}
