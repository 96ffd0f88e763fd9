#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>

#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "planegraph/graph/graph.h"

namespace planegraph {

/// The kinds of parameter blocks; each has a manifold (graph/manifolds.h).
enum class BlockKind { kPose, kPlane, kMap, kScale };

/// One parameter block of the problem: the pose, plane, map or scale of that index in the graph.
struct BlockRef {
  BlockKind kind = BlockKind::kPose;
  int index = 0;
};

/// What a residual belongs to, for reports after the solve. -1: does not apply.
struct ResidualTag {
  int plane = -1;              ///< index in Graph::planes
  int observation = -1;        ///< index in its observations
  int other_observation = -1;  ///< the second one of a pose-pose factor
  int pose_factor = -1;        ///< index in Graph::pose_factors
  int map_factor = -1;         ///< index in Graph::map_factors
  int plane_factor = -1;       ///< index in Graph::plane_factors
};

/// Takes the residuals that a factor makes.
class ResidualSink {
 public:
  virtual ~ResidualSink() = default;
  /// Adds one whitened residual block over different parameter blocks, in the order of the cost's.
  /// Its cost is weight * rho(|r|^2) / 2.
  virtual void Add(std::unique_ptr<ceres::CostFunction> cost, std::vector<BlockRef> blocks,
                   const ResidualTag& tag, double weight) = 0;
};

/// Values of a factor's numeric parameters by name; absent: the default.
using FactorOptions = std::map<std::string, double>;

/// The option's value, or `fallback` where it is not set.
double OptionOr(const FactorOptions& options, const std::string& name, double fallback);

/// A numeric parameter, or a field of the measurement, with its unit.
struct FactorParameter {
  std::string name, unit, description;
  double default_value = 0.0;
  bool is_field = false;     ///< read from the graph, not from FactorOptions
  bool is_positive = false;  ///< zero and less are refused
};

/// A cost function with a point to evaluate it at: for tests and benchmarks that know nothing of
/// the factor.
struct FactorSample {
  std::unique_ptr<ceres::CostFunction> cost;
  std::vector<BlockKind> kinds;
  std::vector<std::vector<double>> values;
};

/// kPlane: planes seen from poses. kMapPlane: planes seen in maps, the counterpart of a kPlane
/// factor. kPlanePair: what is known of two planes. kPose, kMap: measurements of poses, of maps.
enum class FactorKind { kPlane, kMapPlane, kPlanePair, kPose, kMap };
/// "plane", "map plane", "plane pair", "pose", "map".
const char* ToString(FactorKind kind);

/// A cost variant. It lives in one file factors/NAME.cc with a function Register_NAME.
struct FactorType {
  std::string name;
  FactorKind kind = FactorKind::kPlane;
  std::string description;  ///< one line
  std::string residual;     ///< order, frame, units
  std::string source;       ///< one line: the paper that it is from, or whose derivation
  std::vector<FactorParameter> parameters;
  bool plane_blocks = false;  ///< the planes are unknowns of the problem
  /// Plane kind: the kMapPlane factor for what maps see of the planes; its own name where it takes
  /// poses and maps alike, empty where it has none.
  std::string map_counterpart;
  /// Plane kind: another factor of the same cost to linearize instead for covariances and for the
  /// pose graph, where this one's residuals do not fall into observations. Empty: itself.
  std::string linearized_as;

  /// Both plane kinds: adds the residuals of the observations of Graph::planes[index] that are the
  /// kind's.
  std::function<void(const Graph& graph, int index, const FactorOptions& options,
                     ResidualSink* sink)>
      add_plane;
  /// Pose kind: the cost over the blocks of factor.poses, in that order, then of its scale.
  std::function<std::unique_ptr<ceres::CostFunction>(const PoseFactor& factor)> make_cost;
  /// Plane kind: how steps are applied to a plane's block; null: PlaneManifold.
  std::function<std::unique_ptr<ceres::Manifold>(const PlaneLandmark& plane,
                                                 const FactorOptions& options)>
      make_manifold;
  /// Plane pair kind: the cost over the blocks of factor.planes, in that order.
  std::function<std::unique_ptr<ceres::CostFunction>(const Graph& graph, const PlaneFactor& factor)>
      make_pair_cost;
  /// Map kind: the cost over the blocks of factor.maps, in that order.
  std::function<std::unique_ptr<ceres::CostFunction>(const MapFactor& factor)> make_map_cost;
  /// All: a random cost and state, over the full range of scales and angles.
  std::function<FactorSample(std::mt19937_64* rng)> sample;

  /// Throws UsageError for an option that the factor does not have, or a value that it cannot take.
  void CheckOptions(const FactorOptions& options) const;
};

/// A factor's name with values of its numeric parameters.
struct FactorChoice {
  std::string name;
  FactorOptions options;
};

/// The cost variants by name.
class FactorRegistry {
 public:
  /// Throws std::invalid_argument for a name that is taken.
  void Add(FactorType type);
  /// Throws UsageError, with the names there are, for one that does not exist or is of another
  /// kind.
  const FactorType& Get(const std::string& name, FactorKind kind) const;
  /// The factor that adds what maps see of the planes: the plane factor's counterpart, or null
  /// where it does so itself. Throws UsageError where nothing does.
  const FactorType* MapPlaneFactorFor(const FactorType& plane_factor) const;
  /// Reads NAME or NAME:OPTION=VALUE[,OPTION=VALUE...]. Throws UsageError for what is not so, for
  /// an unknown factor of that kind, or an option that it does not have.
  FactorChoice Parse(const std::string& text, FactorKind kind) const;
  const std::map<std::string, FactorType>& types() const { return types_; }

 private:
  std::map<std::string, FactorType> types_;
};

/// Generated by CMake: calls Register_NAME of every factors/NAME.cc.
void RegisterAllFactors(FactorRegistry* registry);

/// All factors of the folder factors/.
const FactorRegistry& BuiltinFactors();

}  // namespace planegraph
