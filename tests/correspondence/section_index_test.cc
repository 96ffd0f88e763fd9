#include "planegraph/correspondence/section_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace planegraph {
namespace {

std::vector<Surfel> Random(std::size_t count, double half_extent) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> uniform(-half_extent, half_extent);
  std::vector<Surfel> surfels(count);
  for (Surfel& s : surfels) s.mean = {uniform(engine), uniform(engine), 0.1 * uniform(engine)};
  return surfels;
}

TEST(SectionIndex, HasAllOfTheBallInOrderAndLittleBesideIt) {
  std::mt19937_64 engine(6);
  std::uniform_real_distribution<double> uniform(-80.0, 80.0);
  const std::vector<Surfel> surfels = Random(3000, 60.0);
  const SectionIndex index(surfels);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d centre(uniform(engine), uniform(engine), 0.1 * uniform(engine));
    const double radius = std::abs(uniform(engine)) / 2;
    const auto found = index.Near(centre, radius);
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
    EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
    for (std::uint32_t i = 0; i < surfels.size(); ++i) {
      const Eigen::Vector3d d = (surfels[i].mean - centre).cwiseAbs();
      const bool has = std::binary_search(found.begin(), found.end(), i);
      if (d.norm() <= radius) {
        EXPECT_TRUE(has) << i;
      }
      if (d.head<2>().maxCoeff() > radius + 10.0) {
        EXPECT_FALSE(has) << i;
      }
    }
  }
}

TEST(SectionIndex, NothingIsNearNothing) {
  EXPECT_TRUE(SectionIndex({}).Near({0, 0, 0}, 100.0).empty());
  const SectionIndex index(Random(10, 5.0));
  EXPECT_TRUE(index.Near({1000, 0, 0}, 100.0).empty());
  EXPECT_TRUE(index.Near({NAN, 0, 0}, 100.0).empty());
  EXPECT_EQ(index.Near({0, 0, 0}, 100.0).size(), 10u);
}

}  // namespace
}  // namespace planegraph
