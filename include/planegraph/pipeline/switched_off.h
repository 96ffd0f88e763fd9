#pragma once

#include <string>
#include <vector>

namespace planegraph {

/// Below this weight an observation or a measurement is off.
inline constexpr double kOffWeight = 0.05;

/// A registration or a measurement that takes no part in the result, and why.
struct SwitchedOff {
  std::string kind;            ///< laser-laser, laser-map, or the factor's type
  std::string target, source;  ///< ids of scans and maps; the source may be empty
  std::string by;              ///< "consistency" (before the solve) or "loss"
  double weight = 0.0;         ///< the largest one that the loss left to any part of it
  /// What it is off by, and what it may be: norm of the whitened residual in sigmas; of planes the
  /// root mean square over all of them, and the limit of one.
  double sigmas = 0.0, threshold_sigmas = 0.0;
  std::vector<std::string> contradicts = {};  ///< TARGET-SOURCE of registrations that were kept
  std::string reason = "";                    ///< in words
};

}  // namespace planegraph
