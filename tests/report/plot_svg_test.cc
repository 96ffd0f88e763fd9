#include "report/plot_svg.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

namespace planegraph {
namespace {

// The least y (that is the highest on the page) that follows `attribute` in elements of a class.
double HighestOf(const std::string& svg, const std::string& element, const std::string& attribute) {
  double highest = 1e9;
  for (auto at = svg.find(element); at != std::string::npos; at = svg.find(element, at + 1)) {
    const auto value = svg.find(attribute + "=\"", at);
    highest = std::min(highest, std::atof(svg.c_str() + value + attribute.size() + 2));
  }
  return highest;
}

TEST(PlotSvg, TheGridReachesTheLargestValue) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(-4.0, 4.0), share(0.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    const double size = std::pow(10.0, exponent(random));
    PlotLine line{"r0", 0.0, {}};
    for (int k = 0; k < 5; ++k) line.values.push_back(size * share(random));
    const std::string svg = PlotHtml({line}, {"label", "across", "up"}, false);
    const double grid = HighestOf(svg, "<line ", "y1"), marks = HighestOf(svg, "<circle ", "cy");
    ASSERT_LT(grid, 1e9) << svg;
    EXPECT_LE(grid, marks + 0.06) << svg;  // places are printed with one decimal
    // And not much of the drawing stays empty: less than a step of two to five.
    EXPECT_LT(marks - grid, 190.0 / 2.0) << svg;
  }
}

}  // namespace
}  // namespace planegraph
