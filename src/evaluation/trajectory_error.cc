#include "planegraph/evaluation/trajectory_error.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "planegraph/base/error.h"
#include "planegraph/evaluation/interval.h"
#include "planegraph/geometry/alignment.h"
#include "planegraph/geometry/moments.h"
#include "planegraph/geometry/rotation.h"

namespace planegraph {
namespace {

// A similarity whose rotation is a matrix as it stands (see MatrixPose).
struct MatrixSim {
  double scale = 1.0;
  MatrixPose pose;
};

// target_from_source^-1 * target_from_other for rotations taken as orthonormal.
MatrixPose Between(const MatrixPose& a, const MatrixPose& b) {
  const Eigen::Matrix3d inverse = a.rotation.transpose();
  return {inverse * b.rotation, inverse * (b.translation - a.translation)};
}

MatrixPose Apply(const MatrixSim& sim, const MatrixPose& pose) {
  return {sim.pose.rotation * pose.rotation,
          sim.scale * (sim.pose.rotation * pose.translation) + sim.pose.translation};
}

double Angle(const Eigen::Matrix3d& rotation) {
  return LogSO3(Eigen::Quaterniond(ProjectToRotation(rotation)).normalized()).norm();
}

std::vector<Eigen::Vector3d> Positions(const std::vector<MatrixPose>& poses) {
  std::vector<Eigen::Vector3d> positions;
  for (const MatrixPose& pose : poses) positions.push_back(pose.translation);
  return positions;
}

// Root mean square spread of the positions along their two widest directions.
std::pair<double, double> SpreadAlongAndAcross(const std::vector<Eigen::Vector3d>& positions) {
  Moments moments;
  for (const auto& p : positions) moments.Add(p);
  const Eigen::Vector3d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments.scatter, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .cwiseMax(0.0);
  return {std::sqrt(values[2] / moments.count), std::sqrt(values[1] / moments.count)};
}

double Misfit(const Sim3& target_from_source, const std::vector<Eigen::Vector3d>& source,
              const std::vector<Eigen::Vector3d>& target) {
  double sum = 0.0;
  for (std::size_t i = 0; i < source.size(); ++i) {
    sum += (target_from_source * source[i] - target[i]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(source.size()));
}

// Nearly straight paths pass the numerical rank test, but the rotation about the line would be
// fitted to the errors alone.
constexpr double kLineRatio = 0.01, kLineWidth = 0.05, kLineMisfits = 3.0;

bool IsLine(const std::vector<Eigen::Vector3d>& positions, double misfit) {
  const auto [along, across] = SpreadAlongAndAcross(positions);
  return across < kLineRatio * along && across < std::max(kLineWidth, kLineMisfits * misfit);
}

Sim3 AlignPositions(const PosePairs& pairs, bool with_scale) {
  const auto source = Positions(pairs.estimate), target = Positions(pairs.reference);
  const Alignment alignment = AlignPoints(source, target, with_scale);
  const double misfit = Misfit(alignment.target_from_source, source, target);
  if (alignment.rank < 2 || IsLine(source, misfit) || IsLine(target, misfit)) {
    throw NoResultError("the positions lie on a line (rank below 2): " +
                        Name(with_scale ? PoseAlignment::kSim3 : PoseAlignment::kSe3) +
                        " alignment is not defined, use first or none");
  }
  return alignment.target_from_source;
}

MatrixSim AlignMatrices(const PosePairs& pairs, PoseAlignment alignment) {
  if (pairs.reference.empty()) throw NoResultError("there are no pairs of poses to align");
  if (alignment == PoseAlignment::kNone) return {};
  if (alignment == PoseAlignment::kFirst) {
    const MatrixPose &q = pairs.reference[0], &p = pairs.estimate[0];
    const Eigen::Matrix3d rotation = q.rotation * p.rotation.transpose();
    return {1.0, {rotation, q.translation - rotation * p.translation}};
  }
  const Sim3 sim = AlignPositions(pairs, alignment == PoseAlignment::kSim3);
  return {sim.scale, {sim.rotation.toRotationMatrix(), sim.translation}};
}

Sim3 ToSim3(const MatrixSim& sim) {
  const Eigen::Quaterniond rotation(ProjectToRotation(sim.pose.rotation));
  return {sim.scale, rotation.normalized(), sim.pose.translation};
}

void AddError(const MatrixPose& error, PoseErrors* errors) {
  errors->translation_errors.push_back(error.translation.norm());
  errors->rotation_errors.push_back(Angle(error.rotation));
}

void SummarizeErrors(PoseErrors* errors) {
  errors->count = errors->translation_errors.size();
  errors->translation = Summarize(errors->translation_errors);
  errors->rotation = Summarize(errors->rotation_errors);
}

PoseErrors ErrorsUnder(const MatrixSim& sim, const PosePairs& pairs) {
  PoseErrors errors;
  for (std::size_t i = 0; i < pairs.reference.size(); ++i) {
    AddError(Between(pairs.reference[i], Apply(sim, pairs.estimate[i])), &errors);
  }
  SummarizeErrors(&errors);
  return errors;
}

template <typename T>
std::vector<T> Without(std::vector<T> values, const std::pair<std::size_t, std::size_t>& block) {
  const auto at = [&](std::size_t i) { return values.begin() + static_cast<std::ptrdiff_t>(i); };
  values.erase(at(block.first), at(block.second));
  return values;
}

PoseErrors ErrorsWithout(const PoseErrors& errors,
                         const std::pair<std::size_t, std::size_t>& block) {
  PoseErrors rest;
  rest.translation_errors = Without(errors.translation_errors, block);
  rest.rotation_errors = Without(errors.rotation_errors, block);
  SummarizeErrors(&rest);
  return rest;
}

const std::pair<PoseAlignment, const char*> kAlignmentNames[] = {{PoseAlignment::kSe3, "se3"},
                                                                 {PoseAlignment::kSim3, "sim3"},
                                                                 {PoseAlignment::kFirst, "first"},
                                                                 {PoseAlignment::kNone, "none"}};

}  // namespace

PoseAlignment ParsePoseAlignment(const std::string& name) {
  for (const auto& [alignment, text] : kAlignmentNames) {
    if (name == text) return alignment;
  }
  throw UsageError("unknown alignment '" + name + "' (se3, sim3, first or none)");
}

std::string Name(PoseAlignment alignment) {
  for (const auto& [candidate, text] : kAlignmentNames) {
    if (alignment == candidate) return text;
  }
  return "";
}

Sim3 AlignPoses(const PosePairs& pairs, PoseAlignment alignment) {
  return ToSim3(AlignMatrices(pairs, alignment));
}

AteResult ComputeAte(const PosePairs& pairs, PoseAlignment alignment) {
  const MatrixSim sim = AlignMatrices(pairs, alignment);
  return {ErrorsUnder(sim, pairs), alignment, ToSim3(sim)};
}

std::vector<MatrixPose> AlignedEstimate(const PosePairs& pairs, const AteResult& ate) {
  const Sim3& sim = ate.reference_from_estimate;
  const MatrixSim matrix{sim.scale, {sim.rotation.toRotationMatrix(), sim.translation}};
  std::vector<MatrixPose> aligned;
  for (const MatrixPose& pose : pairs.estimate) aligned.push_back(Apply(matrix, pose));
  return aligned;
}

RpeResult ComputeRpe(const PosePairs& pairs, const RpeOptions& options, double scale) {
  std::vector<MatrixPose> estimate = pairs.estimate;
  for (MatrixPose& pose : estimate) pose.translation *= scale;
  RpeResult result;
  result.options = options;
  const auto& path = options.pairs_from_estimate ? estimate : pairs.reference;
  result.pairs = SelectPairs(path, options);
  for (const auto& [i, j] : result.pairs) {
    const MatrixPose reference_motion = Between(pairs.reference[i], pairs.reference[j]);
    AddError(Between(reference_motion, Between(estimate[i], estimate[j])), &result.errors);
  }
  if (result.errors.translation_errors.empty()) {
    throw NoResultError("the path is too short: no two poses are delta apart");
  }
  SummarizeErrors(&result.errors);
  return result;
}

std::vector<PoseErrors> AteWithoutBlocks(const PosePairs& pairs, const AteResult& ate,
                                         std::size_t blocks) try {
  const bool by_positions =
      ate.alignment == PoseAlignment::kSe3 || ate.alignment == PoseAlignment::kSim3;
  std::vector<PoseErrors> without;
  for (const auto& block : ConsecutiveBlocks(pairs.reference.size(), blocks)) {
    if (!by_positions) {
      without.push_back(ErrorsWithout(ate.errors, block));
      continue;
    }
    PosePairs rest;
    rest.reference = Without(pairs.reference, block);
    rest.estimate = Without(pairs.estimate, block);
    without.push_back(ComputeAte(rest, ate.alignment).errors);
  }
  return without;
} catch (const NoResultError&) {
  return {};
}

std::vector<PoseErrors> RpeWithoutBlocks(const RpeResult& rpe, std::size_t blocks) {
  const std::size_t count = rpe.pairs.size();
  if (rpe.options.all_pairs) {
    std::size_t reach = 1;
    for (const auto& [i, j] : rpe.pairs) reach = std::max(reach, j - i);
    blocks = std::min(blocks, count / reach);
  }
  std::vector<PoseErrors> without;
  if (count < 2) return without;
  for (const auto& block : ConsecutiveBlocks(count, blocks)) {
    if (block.second - block.first == count) return {};
    without.push_back(ErrorsWithout(rpe.errors, block));
  }
  return without;
}

}  // namespace planegraph
