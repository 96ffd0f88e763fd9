#include "graph/largest_clique.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace planegraph {
namespace {

using Vertices = std::vector<std::size_t>;

class CliqueSearch {
 public:
  CliqueSearch(const std::vector<std::vector<bool>>& adjacent, int most_steps)
      : adjacent_(adjacent), steps_left_(most_steps) {}

  Vertices Run() {
    Vertices all(adjacent_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    std::vector<std::ptrdiff_t> degree;
    for (const auto& row : adjacent_) degree.push_back(std::count(row.begin(), row.end(), true));
    std::stable_sort(all.begin(), all.end(),
                     [&](std::size_t a, std::size_t b) { return degree[a] > degree[b]; });
    Expand(all);
    std::sort(best_.begin(), best_.end());
    return best_;
  }

 private:
  // The vertices with a bound of the largest clique among those up to each: colour classes, within
  // which no two are neighbours, in increasing order.
  std::vector<std::pair<std::size_t, std::size_t>> Colour(const Vertices& candidates) const {
    std::vector<Vertices> classes;
    for (const std::size_t v : candidates) {
      const auto free = std::find_if(classes.begin(), classes.end(), [&](const Vertices& members) {
        return std::none_of(members.begin(), members.end(),
                            [&](std::size_t w) { return adjacent_[v][w]; });
      });
      (free == classes.end() ? classes.emplace_back() : *free).push_back(v);
    }
    std::vector<std::pair<std::size_t, std::size_t>> coloured;
    for (std::size_t c = 0; c < classes.size(); ++c) {
      for (const std::size_t v : classes[c]) coloured.push_back({v, c + 1});
    }
    return coloured;
  }

  void Expand(const Vertices& candidates) {
    const auto coloured = Colour(candidates);
    for (std::size_t k = coloured.size(); k-- > 0;) {
      const auto [vertex, bound] = coloured[k];
      if (present_.size() + bound <= best_.size()) return;
      if (steps_left_-- <= 0 && !best_.empty()) return;
      Vertices next;
      for (std::size_t j = 0; j < k; ++j) {
        if (adjacent_[vertex][coloured[j].first]) next.push_back(coloured[j].first);
      }
      present_.push_back(vertex);
      if (present_.size() > best_.size()) best_ = present_;
      Expand(next);
      present_.pop_back();
    }
  }

  const std::vector<std::vector<bool>>& adjacent_;
  int steps_left_;
  Vertices present_, best_;
};

}  // namespace

std::vector<std::size_t> LargestClique(const std::vector<std::vector<bool>>& adjacent,
                                       int most_steps) {
  return CliqueSearch(adjacent, most_steps).Run();
}

}  // namespace planegraph
