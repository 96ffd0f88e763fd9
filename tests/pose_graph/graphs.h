#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "planegraph/pose_graph/pose_graph.h"
#include "pose_graph/edge_model.h"

namespace planegraph {

template <int Dim>
Eigen::Matrix<double, kPoseDimension<Dim>, 1> RandomStep(std::mt19937_64* rng, double translation,
                                                         double rotation) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, kPoseDimension<Dim>, 1> step;
  for (int i = 0; i < step.size(); ++i) step[i] = (i < Dim ? translation : rotation) * normal(*rng);
  return step;
}

template <int Dim>
GraphPose<Dim> RandomPose(std::mt19937_64* rng) {
  return Retract<Dim>({}, RandomStep<Dim>(rng, 5.0, 1.5));
}

template <int Dim>
GraphPose<Dim> Relative(const GraphPose<Dim>& from, const GraphPose<Dim>& to) {
  return {from.rotation.transpose() * to.rotation,
          from.rotation.transpose() * (to.translation - from.translation)};
}

template <int Dim>
GraphPose<Dim> Compose(const GraphPose<Dim>& a, const GraphPose<Dim>& b) {
  return {a.rotation * b.rotation, a.rotation * b.translation + a.translation};
}

template <int Dim>
PoseInformation<Dim> RandomInformation(std::mt19937_64* rng) {
  std::normal_distribution<double> normal;
  PoseInformation<Dim> root;
  for (int i = 0; i < root.size(); ++i) root.data()[i] = normal(*rng);
  return root * root.transpose() + 0.1 * PoseInformation<Dim>::Identity();
}

/// A walk of random poses with a loop closure from every third pose to one that lies `span` back,
/// measured with noise of the given sigmas and weighted by them; the poses are the truth.
template <int Dim>
PoseGraph<Dim> NoisyGraph(int count, double sigma_translation, double sigma_rotation,
                          std::uint64_t seed, int span = 7) {
  std::mt19937_64 rng(seed);
  PoseGraph<Dim> graph;
  for (int i = 0; i < count; ++i) {
    const GraphPose<Dim> step = Retract<Dim>({}, RandomStep<Dim>(&rng, 1.0, 0.4));
    graph.poses.push_back(i == 0 ? GraphPose<Dim>() : Compose(graph.poses.back(), step));
  }
  graph.fixed.assign(count, false);
  const double tau = 1.0 / std::pow(std::max(sigma_translation, 1e-3), 2);
  const double kappa = 0.5 / std::pow(std::max(sigma_rotation, 1e-3), 2);
  const auto information = IsotropicInformation<Dim>({tau, kappa});
  const auto add = [&](int from, int to) {
    const GraphPose<Dim> truth = Relative(graph.poses[from], graph.poses[to]);
    const auto noise = RandomStep<Dim>(&rng, sigma_translation, sigma_rotation);
    graph.edges.push_back({from, to, Retract<Dim>(truth, noise), information, to != from + 1});
  };
  for (int i = 0; i + 1 < count; ++i) add(i, i + 1);
  for (int i = span; i < count; i += 3) add(i - span, i);
  return graph;
}

/// Largest difference of rotations (Frobenius) and translations after the first poses are made one.
template <int Dim>
double LargestDifference(const std::vector<GraphPose<Dim>>& a,
                         const std::vector<GraphPose<Dim>>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const GraphPose<Dim> x = Relative(a[0], a[i]), y = Relative(b[0], b[i]);
    largest = std::max(
        {largest, (x.rotation - y.rotation).norm(), (x.translation - y.translation).norm()});
  }
  return largest;
}

/// Poses of the plane in a ring whose every edge turns by nothing, started so that the rotations
/// wind once around: a local minimum of the cost (the global one is zero, at equal rotations).
inline PoseGraph2 WoundRing(int count) {
  PoseGraph2 graph;
  for (int i = 0; i < count; ++i) {
    GraphPose<2> pose;
    pose.rotation = Eigen::Rotation2Dd(2.0 * std::numbers::pi * i / count).toRotationMatrix();
    graph.poses.push_back(pose);
    graph.edges.push_back({i, (i + 1) % count, {}, IsotropicInformation<2>({1.0, 1.0}), false});
  }
  graph.fixed.assign(count, false);
  return graph;
}

}  // namespace planegraph
