#pragma once

#include <string>
#include <vector>

namespace planegraph {

/// A line of a plot with a mark at every value. x counts from `first` by ones.
struct PlotLine {
  std::string style;  ///< class that carries the colour
  double first = 0.0;
  std::vector<double> values;
};

struct PlotText {
  std::string label;   ///< describes the picture to those who cannot see it
  std::string across;  ///< name of the x axis
  std::string up;      ///< of the y axis, with its unit
};

/// A plot as SVG in the page's style. The y axis begins at zero; with `logarithmic` and positive
/// values it is logarithmic where these differ much, and else begins at the least of them. Values
/// that are not finite are left out. Empty where there are no values.
std::string PlotHtml(const std::vector<PlotLine>& lines, const PlotText& text, bool logarithmic);

}  // namespace planegraph
