#include "solve/residual_scatter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "solve/group_system.h"

namespace planegraph {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Longer residuals (of single points) have no components of their own.
constexpr Index kMostComponents = 6;
// Twice this is the prior's degrees of freedom, at the stated variance.
constexpr double kPrior = 2.0;
// A loss that takes more than that from an observation's information has switched it off.
constexpr double kLeastCurvature = 0.01;

/// Rows of residuals that are alike: by the residual's length and their place in it.
using Component = std::pair<Index, Index>;
Component ComponentOf(Index rows, Index row) { return {rows, rows <= kMostComponents ? row : 0}; }

// Sums over rows. What counts is the scatter of the nodes' scores, in which a row has the share of
// its leverage on the nodes; where floors of the noise are too large, they are so for the rows of
// many points, which have the most.
struct Variance {
  double squares = 0.0, redundancy = 0.0;  // of residuals, times the leverage
  double spread = 0.0;                     // redundancy times the square of the leverage
  double leverage = 0.0;                   // on the nodes

  double Freedom() const { return spread > 0.0 ? redundancy * redundancy / spread : 0.0; }
};

template <typename Function>
void ForEachResidual(LinearizedGraph* linear, const Function& function) {
  for (auto& plane : linear->planes) {
    for (PlaneResidual& residual : plane) function(residual);
  }
}

// Neighbouring surfaces of a map err together. Their stated variances are raised for that, but no
// residual shows it: they stay as they are.
bool TellsItsNoise(const PlaneResidual& residual) {
  return residual.tag.plane >= 0 &&
         std::none_of(residual.blocks.begin(), residual.blocks.end(),
                      [](const BlockRef& block) { return block.kind == BlockKind::kMap; });
}

// What share of |r|^2 one row of each component has on average.
std::map<Component, double> Shares(LinearizedGraph* linear) {
  std::map<Index, double> squares;
  std::map<Component, double> shares;
  ForEachResidual(linear, [&](const PlaneResidual& residual) {
    const VectorXd& r = residual.linear.residual;
    squares[r.size()] += r.squaredNorm();
    const double rows = r.size() > kMostComponents ? static_cast<double>(r.size()) : 1.0;
    for (Index k = 0; k < r.size(); ++k) {
      shares[ComponentOf(r.size(), k)] += r[k] * r[k] / rows;
    }
  });
  for (auto& [component, share] : shares) {
    share = squares[component.first] > 0.0 ? share / squares[component.first] : 0.0;
  }
  return shares;
}

// Leverages and residuals of the planes that are eliminated together.
class GroupLeverage {
 public:
  GroupLeverage(const std::vector<const PlaneResidual*>& residuals, const PoseSystem& system,
                const PoseInformation& numbers)
      : system_(system), numbers_(numbers), group_(residuals, numbers) {
    SetWithPlanes();
    of_planes_ = group_.following() * with_planes_;
    VectorXd gradient = VectorXd::Zero(group_.inverse().rows());
    for (const PlaneResidual* residual : residuals) {
      gradient += group_.ByPlanes(*residual).transpose() *
                  residual->linear.residual.cwiseQuotient(RootCurvature(*residual));
    }
    step_ = -group_.inverse() * gradient;
  }

  void Add(const PlaneResidual& residual, std::map<Component, Variance>* variances) const {
    const MatrixXd by_planes = group_.ByPlanes(residual);
    const VectorXd root = RootCurvature(residual);
    const VectorXd left = residual.linear.residual + (by_planes * step_).cwiseQuotient(root);
    const VectorXd on_nodes = OnNodes(residual, by_planes).cwiseMax(0.0);
    const VectorXd on_planes = DiagonalOf(by_planes * group_.inverse(), by_planes);
    for (Index k = 0; k < left.size(); ++k) {
      Variance& variance = (*variances)[ComponentOf(left.size(), k)];
      const double redundancy = std::max(0.0, 1.0 - on_nodes[k] - on_planes[k]);
      variance.squares += on_nodes[k] * left[k] * left[k];
      variance.redundancy += on_nodes[k] * redundancy;
      variance.spread += on_nodes[k] * on_nodes[k] * redundancy;
      variance.leverage += on_nodes[k];
    }
  }

 private:
  // C N^T. The whole C of a surface that thousands of scans see would fill the memory.
  void SetWithPlanes() {
    const MatrixXd follow = group_.following().transpose();
    with_planes_ = MatrixXd::Zero(group_.rows(), follow.cols());
    for (auto a = group_.nodes().begin(); a != group_.nodes().end(); ++a) {
      const auto [row, rows] = a->second;
      for (auto b = group_.nodes().begin(); b != a; ++b) {
        const auto [column, columns] = b->second;
        const NodeBlock block = system_.Block(a->first, b->first);
        with_planes_.middleRows(row, rows).noalias() += block * follow.middleRows(column, columns);
        with_planes_.middleRows(column, columns).noalias() +=
            block.transpose() * follow.middleRows(row, rows);
      }
      with_planes_.middleRows(row, rows) +=
          system_.Block(a->first, a->first) * follow.middleRows(row, rows);
    }
  }

  static VectorXd RootCurvature(const PlaneResidual& residual) {
    return residual.curvature.size() > 0 ? VectorXd(residual.curvature.cwiseSqrt())
                                         : VectorXd::Ones(residual.linear.residual.size());
  }

  static VectorXd DiagonalOf(const MatrixXd& left, const MatrixXd& right) {
    return left.cwiseProduct(right).rowwise().sum();
  }

  // The diagonal of X C X^T, X = J_p - J_l N: N is how the planes follow the nodes.
  VectorXd OnNodes(const PlaneResidual& residual, const MatrixXd& by_planes) const {
    VectorXd leverage = DiagonalOf(by_planes * of_planes_, by_planes);
    const auto& jacobians = residual.linear.jacobians;
    for (std::size_t a = 0; a < residual.blocks.size(); ++a) {
      if (residual.blocks[a].kind == BlockKind::kPlane) continue;
      const int node = numbers_.NodeOf(residual.blocks[a]);
      const auto& [row, rows] = group_.nodes().at(node);
      leverage -= 2.0 * DiagonalOf(jacobians[a] * with_planes_.middleRows(row, rows), by_planes);
      for (std::size_t b = 0; b < residual.blocks.size(); ++b) {
        if (residual.blocks[b].kind == BlockKind::kPlane) continue;
        const NodeBlock covariance = system_.Block(node, numbers_.NodeOf(residual.blocks[b]));
        leverage += DiagonalOf(jacobians[a] * covariance, jacobians[b]);
      }
    }
    return leverage;
  }

  const PoseSystem& system_;
  const PoseInformation& numbers_;
  GroupSystem group_;
  MatrixXd with_planes_, of_planes_;
  VectorXd step_;  // of the planes to their own minimum, where they are not there
};

using PlaneVariances = std::vector<std::map<Component, Variance>>;

PlaneVariances MeasureVariances(const PoseSystem& system, const NodeNumbers& numbers,
                                const LinearizedGraph& linear) {
  const PlaneGroups groups(linear);
  const PoseInformation nodes(numbers);
  PlaneVariances variances(linear.planes.size());
  for (int k = 0; k < static_cast<int>(linear.planes.size()); ++k) {
    if (!groups.IsFirst(k)) continue;
    const auto residuals = groups.Residuals(k);
    if (residuals.empty()) continue;
    const GroupLeverage leverage(residuals, system, nodes);
    for (const PlaneResidual* residual : residuals) {
      if (TellsItsNoise(*residual)) leverage.Add(*residual, &variances[residual->tag.plane]);
    }
  }
  return variances;
}

double Posterior(double freedom, double sum) { return (sum + kPrior) / (freedom + kPrior); }

/// What each component's residuals say of its variance, as a factor of the stated one.
std::map<Component, double> OverAll(const PlaneVariances& planes) {
  std::map<Component, Variance> sums;
  for (const auto& plane : planes) {
    for (const auto& [component, variance] : plane) {
      sums[component].squares += variance.squares;
      sums[component].redundancy += variance.redundancy;
      sums[component].spread += variance.spread;
    }
  }
  std::map<Component, double> factors;
  for (const auto& [component, sum] : sums) {
    const double mean = sum.redundancy > 0.0 ? sum.squares / sum.redundancy : 1.0;
    factors[component] = Posterior(sum.Freedom(), sum.Freedom() * mean);
  }
  return factors;
}

// Factors of each plane's components; together they take the place of the stated variances as far
// as their degrees of freedom go, which are those of equal variances (Bell and McCaffrey 2002).
std::vector<std::map<Component, double>> Factors(const PlaneVariances& planes) {
  const std::map<Component, double> over_all = OverAll(planes);
  std::vector<std::map<Component, double>> factors(planes.size());
  double sum = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    for (const auto& [component, own] : planes[k]) {
      const double own_freedom = own.Freedom(), borrowed = std::max(0.0, 1.0 - own_freedom);
      const double freedom = own_freedom + borrowed;
      const double mean = own.redundancy > 0.0 ? own.squares / own.redundancy : 0.0;
      factors[k][component] = (own_freedom * mean + borrowed * over_all.at(component)) / freedom;
      sum += own.leverage;
      squares += own.leverage * own.leverage / freedom;
    }
  }
  const double freedom = squares > 0.0 ? sum * sum / squares : 0.0;
  for (auto& plane : factors) {
    for (auto& [component, factor] : plane) factor = Posterior(freedom, freedom * factor);
  }
  return factors;
}

}  // namespace

void ApplyLossCurvature(LinearizedGraph* linear) {
  const std::map<Component, double> shares = Shares(linear);
  ForEachResidual(linear, [&](PlaneResidual& residual) {
    const Index rows = residual.linear.residual.size();
    residual.curvature.resize(rows);
    for (Index k = 0; k < rows; ++k) {
      const double taken = residual.linear.radial_curvature * shares.at(ComponentOf(rows, k));
      residual.curvature[k] = std::max(kLeastCurvature, 1.0 + taken);
    }
    const VectorXd root = residual.curvature.cwiseSqrt();
    for (MatrixXd& jacobian : residual.linear.jacobians) jacobian = root.asDiagonal() * jacobian;
  });
}

void SetResidualScatter(const PoseSystem& system, const NodeNumbers& numbers,
                        LinearizedGraph* linear) {
  const auto factors = Factors(MeasureVariances(system, numbers, *linear));
  ForEachResidual(linear, [&](PlaneResidual& residual) {
    const Index rows = residual.linear.residual.size();
    residual.scatter.resize(rows);
    const bool by_residuals = TellsItsNoise(residual);
    for (Index k = 0; k < rows; ++k) {
      const double factor =
          by_residuals ? factors[residual.tag.plane].at(ComponentOf(rows, k)) : 1.0;
      residual.scatter[k] = factor / (residual.curvature.size() > 0 ? residual.curvature[k] : 1.0);
    }
  });
}

PoseInformation ScoreScatter(const LinearizedGraph& linear, const NodeNumbers& numbers) {
  PoseInformation scatter(numbers);
  const PlaneGroups groups(linear);
  for (int k = 0; k < static_cast<int>(linear.planes.size()); ++k) {
    if (!groups.IsFirst(k)) continue;
    const auto residuals = groups.Residuals(k);
    if (!residuals.empty()) AddPlaneGroupScatter(residuals, &scatter);
  }
  for (const auto& factor : linear.pose_factors) AddPoseFactorInformation(factor, &scatter);
  return scatter;
}

}  // namespace planegraph
