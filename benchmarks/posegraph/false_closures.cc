#include "posegraph/false_closures.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <set>
#include <utility>

#include "planegraph/base/error.h"
#include "planegraph/simulation/random.h"

namespace planegraph {
namespace {

constexpr int kRun = 10;  // closures in a group

class FalseClosures {
 public:
  FalseClosures(FalseClosureKind kind, std::uint64_t seed, G2oGraph* graph)
      : kind_(kind),
        random_(seed),
        graph_(*graph),
        poses_(static_cast<int>(graph->vertices3.size())) {
    for (const G2oEdge3& edge : graph->edges3) {
      taken_.insert(std::minmax(edge.from, edge.to));
      if (std::abs(edge.to - edge.from) != 1) closures_.push_back(edge);
    }
    for (const G2oVertex3& vertex : graph->vertices3) {
      extent_ = std::max(extent_,
                         (vertex.pose.translation - graph->vertices3[0].pose.translation).norm());
    }
  }

  void Add(double share) {
    if (closures_.empty()) throw UsageError("a graph without loop closures has no share of them");
    const auto count =
        static_cast<std::size_t>(std::lround(share * static_cast<double>(closures_.size())));
    const int run = kind_ == FalseClosureKind::kGroups ? kRun : 1;
    for (std::size_t added = 0; added < count;) {
      G2oEdge3 edge = Measured();
      const int from = random_.Index(poses_);
      const int to = random_.Index(poses_);
      for (int n = 0; n < run && added < count; ++n) added += Join(from + n, to + n, edge);
    }
  }

 private:
  G2oEdge3 Measured() {
    G2oEdge3 edge = closures_[random_.Index(static_cast<int>(closures_.size()))];
    if (kind_ != FalseClosureKind::kRandom) return edge;
    Eigen::Vector4d q;
    for (double& value : q) value = random_.Normal();
    Eigen::Vector3d direction;
    for (double& value : direction) value = random_.Normal();
    const double distance = extent_ * std::cbrt(random_.Uniform());
    edge.measurement = {Eigen::Quaterniond(q).normalized(), distance * direction.normalized()};
    return edge;
  }

  bool Join(int from, int to, G2oEdge3 edge) {
    if (from >= poses_ || to >= poses_) return false;
    edge.from = graph_.vertices3[from].id;
    edge.to = graph_.vertices3[to].id;
    if (std::abs(edge.to - edge.from) < 2) return false;
    if (!taken_.insert(std::minmax(edge.from, edge.to)).second) return false;
    graph_.edges3.push_back(edge);
    return true;
  }

  FalseClosureKind kind_;
  Random random_;
  G2oGraph& graph_;
  int poses_;
  double extent_ = 0.0;
  std::vector<G2oEdge3> closures_;
  std::set<std::pair<long long, long long>> taken_;
};

}  // namespace

FalseClosureKind ParseFalseClosureKind(const std::string& name) {
  if (name == "random") return FalseClosureKind::kRandom;
  if (name == "lookalike") return FalseClosureKind::kLookalike;
  if (name == "groups") return FalseClosureKind::kGroups;
  throw UsageError("false closures are random, lookalike or groups, not '" + name + "'");
}

void AddFalseClosures(FalseClosureKind kind, double share, std::uint64_t seed, G2oGraph* graph) {
  FalseClosures(kind, seed, graph).Add(share);
}

}  // namespace planegraph
