#pragma once

#include <cstddef>
#include <vector>

namespace planegraph {

/// A largest set of vertices of which any two are neighbours, increasing. `adjacent`: symmetric.
/// Branch and bound with colours (Tomita and Seki 2003); after `most_steps` the largest found so
/// far, which is at least the greedy one.
std::vector<std::size_t> LargestClique(const std::vector<std::vector<bool>>& adjacent,
                                       int most_steps);

}  // namespace planegraph
