#include "planegraph/evaluation/trajectory_plot.h"

#include <algorithm>
#include <cstdio>

namespace planegraph {
namespace {

// Okabe and Ito's colours, told apart by the colour-blind and in grey.
constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7"};
constexpr const char* kReferenceColour = "#555555";
// Fewer poses than this are marked one by one.
constexpr std::size_t kMarked = 60;

std::string Quoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += c;  // gnuplot doubles it
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + "'";
}

std::string Numbers(std::initializer_list<double> values) {
  std::string line;
  for (const double value : values) {
    char text[40];
    std::snprintf(text, sizeof text, "%.9g ", value);
    line += text;
  }
  return line + "\n";
}

std::string Block(const std::string& name, const std::string& lines) {
  return "$" + name + " << EOD\n" + lines + "EOD\n";
}

struct View {
  int horizontal = 0, vertical = 1;
};

// Along the axis of least extent: z for robots, y for cameras.
View ViewOf(const std::vector<Eigen::Vector3d>& positions) {
  Eigen::Vector3d low = positions.front(), high = low;
  for (const auto& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  int along = 2;
  for (int axis = 1; axis >= 0; --axis) {
    if ((high - low)[axis] < (high - low)[along]) along = axis;
  }
  return {along == 0 ? 1 : 0, along == 2 ? 1 : 2};
}

std::string WayLines(const std::vector<Eigen::Vector3d>& positions, const View& view) {
  std::string lines;
  for (const auto& p : positions) lines += Numbers({p[view.horizontal], p[view.vertical]});
  return lines;
}

std::string SeriesBlocks(const TrajectoryPlot& plot, std::size_t k, const View& view) {
  const PlotSeries& series = plot.series[k];
  const double start = plot.has_times ? plot.times.front() : 0.0;
  std::string ate, rpe;
  for (std::size_t i = 0; i < series.ate.size(); ++i) {
    ate += Numbers({plot.times[i] - start, series.ate[i]});
  }
  for (std::size_t i = 0; i < series.rpe.size(); ++i) {
    rpe += Numbers({series.rpe_times[i] - start, series.rpe[i], series.rpe_rotation[i]});
  }
  const std::string number = std::to_string(k);
  return Block("way" + number, WayLines(series.positions, view)) + Block("ate" + number, ate) +
         (rpe.empty() ? "" : Block("rpe" + number, rpe));
}

std::string Style(const char* colour, std::size_t poses) {
  const std::string base = std::string(" lc rgb '") + colour + "' lw 1.6";
  return poses < kMarked ? " with linespoints" + base + " pt 7 ps 0.45" : " with lines" + base;
}

std::string Panel(const std::string& place, const std::string& title, const std::string& x_label,
                  const std::string& y_label) {
  return place + "set title " + Quoted(title) + "\nset xlabel " + Quoted(x_label) +
         "\nset ylabel " + Quoted(y_label) + "\n";
}

// One panel of errors: `columns` as gnuplot's `using`.
std::string ErrorPanel(const TrajectoryPlot& plot, const std::string& place,
                       const std::string& title, const std::string& y_label,
                       const std::string& block, const std::string& columns) {
  std::string curves;
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    const PlotSeries& series = plot.series[k];
    const std::size_t count = block == "ate" ? series.ate.size() : series.rpe.size();
    if (count == 0) continue;
    if (!curves.empty()) curves += ", ";
    curves += "$" + block + std::to_string(k) + " using " + columns + " notitle" +
              Style(kColours[k % 4], count);
  }
  if (curves.empty()) return "";
  return Panel(place, title, plot.has_times ? "time [s]" : "pose", y_label) +
         "set yrange [0:*]\nplot " + curves + "\n";
}

std::string WayPanel(const TrajectoryPlot& plot, const View& view) {
  static constexpr const char* kAxes[] = {"x [m]", "y [m]", "z [m]"};
  std::string text = Panel(
      "set size ratio -1\nset lmargin at screen 0.075\nset rmargin at screen "
      "0.475\nset tmargin at screen 0.93\nset bmargin at screen 0.22\n",
      "Trajectories", kAxes[view.horizontal], kAxes[view.vertical]);
  text +=
      "set key at screen 0.275, screen 0.045 center center horizontal\nset offsets graph 0.05, "
      "graph 0.05, graph 0.05, graph 0.05\n";
  text += "plot $reference using 1:2 title 'reference'" +
          Style(kReferenceColour, plot.times.size()) + " dt 2";
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    text += ", $way" + std::to_string(k) + " using 1:2 title " + Quoted(plot.series[k].name) +
            Style(kColours[k % 4], plot.times.size());
  }
  return text + "\nset size noratio\nunset key\nset offsets 0, 0, 0, 0\n";
}

std::string Place(double top, double bottom) {
  char text[200];
  std::snprintf(text, sizeof text,
                "set lmargin at screen 0.575\nset rmargin at screen 0.975\nset tmargin at screen "
                "%.3f\nset bmargin at screen %.3f\n",
                top, bottom);
  return text;
}

}  // namespace

std::string GnuplotScript(const TrajectoryPlot& plot, const std::string& format) {
  const View view = ViewOf(plot.reference);
  std::string script =
      format == "pdf"
          ? "set terminal pdfcairo noenhanced size 18cm,12cm font 'Helvetica,9' background "
            "'#ffffff'\n"
          : "set terminal svg noenhanced size 900,600 font 'Helvetica,12' background '#ffffff'\n";
  script += Block("reference", WayLines(plot.reference, view));
  for (std::size_t k = 0; k < plot.series.size(); ++k) script += SeriesBlocks(plot, k, view);
  script +=
      "set multiplot\nset grid lc rgb '#dddddd' lt 1 lw 0.6\nset border lc rgb '#444444' lw "
      "0.8\nset tics nomirror textcolor rgb '#222222'\nset xtics autofreq\n";
  script += WayPanel(plot, view);
  script += ErrorPanel(plot, Place(0.93, 0.74), plot.ate_title, "ATE [m]", "ate", "1:2");
  script += ErrorPanel(plot, Place(0.61, 0.42), plot.rpe_title, "RPE [m]", "rpe", "1:2");
  script += ErrorPanel(plot, Place(0.29, 0.10), plot.rpe_title, "RPE [deg]", "rpe", "1:3");
  return script + "unset multiplot\n";
}

}  // namespace planegraph
