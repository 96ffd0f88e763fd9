#include "planegraph/pose_graph/g2o_conversion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <unordered_map>

#include "planegraph/base/error.h"

namespace planegraph {
namespace {

// Of the largest eigenvalue: what rounding makes of a zero in a file with six digits is smaller for
// the matrices of real files; a matrix that is meant to be one thing and is another is far beyond.
constexpr double kNegative = 1e-9;

GraphPose<3> ToPose(const Rigid3& pose) {
  return {pose.rotation.toRotationMatrix(), pose.translation};
}
GraphPose<2> ToPose(const Pose2& pose) {
  return {Eigen::Rotation2Dd(pose.angle).toRotationMatrix(), {pose.x, pose.y}};
}

std::string NameOf(const G2oEdge3& edge) {
  return "edge " + std::to_string(edge.from) + "-" + std::to_string(edge.to);
}
std::string NameOf(const G2oEdge2& edge) {
  return "edge " + std::to_string(edge.from) + "-" + std::to_string(edge.to);
}
std::string NameOf(const G2oPrior3& prior) { return "prior of " + std::to_string(prior.id); }
std::string NameOf(const G2oPrior2& prior) { return "prior of " + std::to_string(prior.id); }

template <typename Matrix>
bool IsIndefinite(const Matrix& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(information, Eigen::EigenvaluesOnly);
  const auto& values = solver.eigenvalues();
  return values[0] < -kNegative * values.cwiseAbs().maxCoeff();
}

template <typename Matrix>
Matrix NearestSemidefinite(const Matrix& information) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(information);
  return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
         solver.eigenvectors().transpose();
}

template <typename List>
void CountIndefinite(const List& list, InformationReport* report) {
  for (const auto& item : list) {
    if (!IsIndefinite(item.information)) continue;
    if (report->indefinite++ == 0) report->first = NameOf(item);
  }
}

// r with twice the half sine has the information of r with the half sine, divided.
PoseInformation<3> ForHalfSine(PoseInformation<3> information, RotationError error) {
  if (error == RotationError::kHalf) return information;
  information.topRightCorner<3, 3>() *= 2.0;
  information.bottomLeftCorner<3, 3>() *= 2.0;
  information.bottomRightCorner<3, 3>() *= 4.0;
  return information;
}
PoseInformation<2> ForHalfSine(const PoseInformation<2>& information, RotationError) {
  return information;
}

template <int Dim>
struct Lists;
template <>
struct Lists<3> {
  static const auto& Vertices(const G2oGraph& file) { return file.vertices3; }
  static const auto& Edges(const G2oGraph& file) { return file.edges3; }
  static const auto& Priors(const G2oGraph& file) { return file.priors3; }
};
template <>
struct Lists<2> {
  static const auto& Vertices(const G2oGraph& file) { return file.vertices2; }
  static const auto& Edges(const G2oGraph& file) { return file.edges2; }
  static const auto& Priors(const G2oGraph& file) { return file.priors2; }
};

template <int Dim>
class Converter {
 public:
  Converter(const G2oGraph& file, const std::string& path, const G2oConversionOptions& options)
      : file_(file), path_(path), options_(options) {}

  PoseGraph<Dim> Convert() {
    AddVertices();
    for (const auto& edge : Lists<Dim>::Edges(file_)) {
      if (edge.from == edge.to) Fail(NameOf(edge) + " joins a vertex with itself");
      const bool odometry = edge.to - edge.from == 1 || edge.from - edge.to == 1;
      Add(edge, index_.at(edge.from), index_.at(edge.to), !odometry);
    }
    AddPriors();
    const bool planar_angle = Dim == 2 && options_.information != InformationUse::kIsotropic;
    graph_.rotation_residual =
        planar_angle ? RotationResidual::kAngle : RotationResidual::kHalfSine;
    return std::move(graph_);
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) const {
    throw InputError::InFile(path_, reason);
  }

  void AddVertices() {
    for (const auto& vertex : Lists<Dim>::Vertices(file_)) {
      index_[vertex.id] = static_cast<int>(graph_.poses.size());
      graph_.poses.push_back(ToPose(vertex.pose));
    }
    graph_.fixed.assign(graph_.poses.size(), false);
    for (const long long id : file_.fixed) {
      const auto found = index_.find(id);
      if (found == index_.end()) Fail("FIX names no vertex: " + std::to_string(id));
      graph_.fixed[found->second] = true;
    }
  }

  // The world is one more pose, which is fixed.
  void AddPriors() {
    if (Lists<Dim>::Priors(file_).empty()) return;
    const int world = static_cast<int>(graph_.poses.size());
    graph_.poses.emplace_back();
    graph_.fixed.push_back(true);
    for (const auto& prior : Lists<Dim>::Priors(file_)) {
      Add(prior, world, index_.at(prior.id), false);
    }
  }

  template <typename Item>
  void Add(const Item& item, int from, int to, bool robust) {
    graph_.edges.push_back({from, to, ToPose(item.measurement), InformationOf(item), robust});
  }

  template <typename Item>
  PoseInformation<Dim> InformationOf(const Item& item) const {
    if (options_.information == InformationUse::kNearest) {
      return ForHalfSine(NearestSemidefinite(item.information), options_.rotation_error);
    }
    if (options_.information == InformationUse::kFile) {
      return ForHalfSine(item.information, options_.rotation_error);
    }
    const IsotropicWeights<Dim> weights = IsotropicWeightsOf<Dim>(item.information);
    if (!(weights.tau > 0.0) || !(weights.kappa > 0.0)) {
      Fail(NameOf(item) + " has no positive isotropic weights");
    }
    return IsotropicInformation<Dim>(weights);
  }

  const G2oGraph& file_;
  const std::string& path_;
  const G2oConversionOptions& options_;
  std::unordered_map<long long, int> index_;
  PoseGraph<Dim> graph_;
};

void RefuseIndefinite(const G2oGraph& file, const std::string& path) {
  const InformationReport report = CheckInformation(file);
  if (report.indefinite == 0) return;
  const std::size_t count =
      file.edges3.size() + file.edges2.size() + file.priors3.size() + file.priors2.size();
  throw InputError::InFile(
      path, std::to_string(report.indefinite) + " of " + std::to_string(count) +
                " information matrices are indefinite, the first of " + report.first +
                ": no minimum exists; --information=isotropic or nearest says what to do instead");
}

}  // namespace

InformationReport CheckInformation(const G2oGraph& file) {
  InformationReport report;
  CountIndefinite(file.edges3, &report);
  CountIndefinite(file.edges2, &report);
  CountIndefinite(file.priors3, &report);
  CountIndefinite(file.priors2, &report);
  return report;
}

bool IsPlanar(const G2oGraph& file, const std::string& path) {
  const bool planar = !file.vertices2.empty() || !file.edges2.empty() || !file.priors2.empty();
  const bool spatial = !file.vertices3.empty() || !file.edges3.empty() || !file.priors3.empty();
  if (planar && spatial) throw InputError::InFile(path, "mixes SE(2) and SE(3)");
  if (file.edges2.empty() && file.edges3.empty()) {
    throw InputError::InFile(path, "holds no EDGE_SE3:QUAT and no EDGE_SE2");
  }
  return planar;
}

template <int Dim>
PoseGraph<Dim> MakePoseGraph(const G2oGraph& file, const std::string& path,
                             const G2oConversionOptions& options) {
  if (options.information == InformationUse::kFile) RefuseIndefinite(file, path);
  return Converter<Dim>(file, path, options).Convert();
}

template <>
void StorePoses<2>(const PoseGraph2& graph, G2oGraph* file) {
  for (std::size_t i = 0; i < file->vertices2.size(); ++i) {
    const GraphPose<2>& pose = graph.poses[i];
    file->vertices2[i].pose = {pose.translation.x(), pose.translation.y(),
                               std::atan2(pose.rotation(1, 0), pose.rotation(0, 0))};
  }
}

template <>
void StorePoses<3>(const PoseGraph3& graph, G2oGraph* file) {
  for (std::size_t i = 0; i < file->vertices3.size(); ++i) {
    const GraphPose<3>& pose = graph.poses[i];
    file->vertices3[i].pose = {Eigen::Quaterniond(pose.rotation).normalized(), pose.translation};
  }
}

template PoseGraph2 MakePoseGraph<2>(const G2oGraph&, const std::string&,
                                     const G2oConversionOptions&);
template PoseGraph3 MakePoseGraph<3>(const G2oGraph&, const std::string&,
                                     const G2oConversionOptions&);

}  // namespace planegraph
