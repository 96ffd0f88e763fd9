#pragma once

#include "solve/pose_system.h"

namespace planegraph {

// The covariance of an M-estimator (Huber 1967; Huber and Ronchetti 2009, "Robust Statistics", 7.6)
// with noise whose size the residuals tell: A^-1 B A^-1, where A is the mean second derivative of
// the robust cost and B the scatter of the scores. Of the planes' observations, B takes the
// residuals' own variance over their redundancy, for each landmark and each component (the two
// tilts, the offset) by itself. Errors that all observations of a landmark share move the landmark
// and no pose. All else (what drone maps observe, whose neighbouring surfaces err together;
// odometry, GPS, gravity, starts, what ties planes) enters B as stated, so that what the planes
// leave open stays as uncertain as that says.

/// Takes the rows of the planes' Jacobians times the root of the curvature that the robust loss
/// leaves them, relative to its weight: 1 + 2 rho'' r_t^2 / rho', the mean over residuals of the
/// same length. Components share the length as they do on average.
void ApplyLossCurvature(LinearizedGraph* linear);

/// Sets the scatter of the planes' residuals. `system`: of the information of `linear`, its loss's
/// curvature applied.
///
/// A variance is the mean of the squares over the rows of a landmark's component, each by its
/// leverage on the nodes: what counts is the scatter of their scores.
///
/// Few residuals say little. A variance is the mean of its posterior under the widest conjugate
/// prior around the stated one, inverse chi-square with four degrees of freedom: (nu s^2 + 2) /
/// (nu + 2). That holds for a component over all landmarks, and for the whole with Satterthwaite's
/// degrees of freedom of the sum over landmarks. A landmark with less than one degree of freedom
/// of its own takes what is missing to one from all others.
void SetResidualScatter(const PoseSystem& system, const NodeNumbers& numbers,
                        LinearizedGraph* linear);

/// The scatter of all scores, those of the pose factors as stated.
PoseInformation ScoreScatter(const LinearizedGraph& linear, const NodeNumbers& numbers);

}  // namespace planegraph
