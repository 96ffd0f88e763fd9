#include "posegraph/ceres_pose_graph.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "thread_seconds.h"

namespace planegraph {
namespace {

struct EdgeError {
  Eigen::Quaterniond rotation;
  Eigen::Vector3d translation;
  Eigen::Matrix<double, 6, 6> root;

  template <typename T>
  bool operator()(const T* t_a, const T* q_a, const T* t_b, const T* q_b, T* out) const {
    using Vector3 = Eigen::Matrix<T, 3, 1>;
    const Eigen::Map<const Vector3> p_a(t_a), p_b(t_b);
    const Eigen::Map<const Eigen::Quaternion<T>> r_a(q_a), r_b(q_b);
    const Eigen::Quaternion<T> to_measured = rotation.conjugate().template cast<T>();
    const Vector3 between = r_a.conjugate() * (p_b - p_a);
    const Eigen::Quaternion<T> error = to_measured * (r_a.conjugate() * r_b);
    Eigen::Map<Eigen::Matrix<T, 6, 1>> residual(out);
    residual.template head<3>() = to_measured * (between - translation.template cast<T>());
    residual.template tail<3>() = error.vec();
    residual.applyOnTheLeft(root.template cast<T>());
    return true;
  }
};

struct Block {
  Eigen::Vector3d t;
  Eigen::Quaterniond q;
};

void AddEdges(const PoseGraph3& graph, std::vector<Block>* blocks, ceres::Problem* problem) {
  for (const GraphEdge<3>& edge : graph.edges) {
    const Eigen::Matrix<double, 6, 6> root = edge.information.llt().matrixU();
    auto* cost = new ceres::AutoDiffCostFunction<EdgeError, 6, 3, 4, 3, 4>(new EdgeError{
        Eigen::Quaterniond(edge.measurement.rotation), edge.measurement.translation, root});
    Block &a = (*blocks)[edge.from], &b = (*blocks)[edge.to];
    problem->AddResidualBlock(cost, nullptr, a.t.data(), a.q.coeffs().data(), b.t.data(),
                              b.q.coeffs().data());
  }
}

}  // namespace

CeresResult SolveWithCeres(const PoseGraph3& graph) {
  std::vector<Block> blocks;
  for (const GraphPose<3>& pose : graph.poses) {
    blocks.push_back({pose.translation, Eigen::Quaterniond(pose.rotation)});
  }
  ceres::Problem problem;
  AddEdges(graph, &blocks, &problem);
  for (Block& block : blocks) {
    problem.SetManifold(block.q.coeffs().data(), new ceres::EigenQuaternionManifold());
  }
  problem.SetParameterBlockConstant(blocks[0].t.data());
  problem.SetParameterBlockConstant(blocks[0].q.coeffs().data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 200;
  ceres::Solver::Summary summary;
  const double start = ThreadSeconds();
  ceres::Solve(options, &problem, &summary);
  return {summary.final_cost, ThreadSeconds() - start,
          static_cast<int>(summary.iterations.size()) - 1};
}

}  // namespace planegraph
