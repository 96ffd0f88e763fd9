#pragma once

namespace planegraph {

/// The probability that chi-square with that many degrees of freedom (>= 1) is above x >= 0: the
/// closed forms of Abramowitz and Stegun, 26.4.4 and 26.4.5.
double ChiSquareTail(double x, int degrees);

/// x with a tail of 1 - probability, to a relative error of 1e-12. Probability in (0, 1).
double ChiSquareQuantile(double probability, int degrees);

}  // namespace planegraph
