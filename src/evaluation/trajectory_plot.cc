#include "planegraph/evaluation/trajectory_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace planegraph {
namespace {

// Okabe and Ito's colours, told apart by the colour-blind and in grey.
constexpr const char* kColours[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7"};
constexpr const char* kReferenceColour = "#bbbbbb";
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

std::string Style(const char* colour, std::size_t poses, double width = 1.6) {
  char text[120];
  std::snprintf(text, sizeof text, " with %s lc rgb '%s' lw %.1f%s",
                poses < kMarked ? "linespoints" : "lines", colour, width,
                poses < kMarked ? " pt 7 ps 0.45" : "");
  return text;
}

std::string Panel(const std::string& place, const std::string& title, const std::string& x_label,
                  const std::string& y_label) {
  return place + "set title " + Quoted(title) + "\nset xlabel " + Quoted(x_label) +
         "\nset ylabel " + Quoted(y_label) + "\n";
}

// 1, 2 or 5 times a power of ten, so that about four steps reach the largest value.
double TicStep(double largest) {
  const double step = largest / 4.0, power = std::pow(10.0, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= step) return factor * power;
  }
  return 10.0 * power;
}

// A kind of error and how it is shown; small ones in thousandths.
struct ErrorKind {
  std::vector<double> PlotSeries::*values;
  std::string block, columns, name, unit, thousandth;
};

double LargestOf(const TrajectoryPlot& plot, const ErrorKind& kind) {
  double largest = 0.0;
  for (const PlotSeries& series : plot.series) {
    for (const double value : series.*kind.values) largest = std::max(largest, value);
  }
  return largest;
}

std::string ErrorPanel(const TrajectoryPlot& plot, const std::string& place,
                       const std::string& title, const std::string& x_label,
                       const ErrorKind& kind) {
  constexpr double kSmall = 0.1;
  const double largest = LargestOf(plot, kind), factor = largest < kSmall ? 1000.0 : 1.0;
  std::string curves;
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    const std::size_t count = (plot.series[k].*kind.values).size();
    if (count == 0) continue;
    curves += (curves.empty() ? "$" : ", $") + kind.block + std::to_string(k) + " using 1:(" +
              (factor > 1.0 ? "1000*" : "") + "column(" + kind.columns + ")) notitle" +
              Style(kColours[k % 4], count);
  }
  if (curves.empty()) return "";
  const double top = largest > 0.0 ? 1.08 * factor * largest : 1.0;
  char range[160];
  std::snprintf(range, sizeof range, "set yrange [0:%.6g]\nset ytics %.6g\nset xrange [0:%.9g]\n",
                top, TicStep(top), plot.times.back() - (plot.has_times ? plot.times.front() : 0.0));
  return Panel(place, title, x_label,
               kind.name + " [" + (factor > 1.0 ? kind.thousandth : kind.unit) + "]") +
         range + "plot " + curves + "\n";
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
          Style(kReferenceColour, plot.times.size(), 4.0);
  for (std::size_t k = 0; k < plot.series.size(); ++k) {
    text += ", $way" + std::to_string(k) + " using 1:2 title " + Quoted(plot.series[k].name) +
            Style(kColours[k % 4], plot.times.size());
  }
  return text + "\nset size noratio\nunset key\nset offsets 0, 0, 0, 0\n";
}

std::string Place(double top, double bottom) {
  char text[200];
  std::snprintf(text, sizeof text,
                "set lmargin at screen 0.595\nset rmargin at screen 0.975\nset tmargin at screen "
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
          : "set terminal svg noenhanced size 900,600 font 'Helvetica,13' background '#ffffff'\n";
  script += Block("reference", WayLines(plot.reference, view));
  for (std::size_t k = 0; k < plot.series.size(); ++k) script += SeriesBlocks(plot, k, view);
  script +=
      "set multiplot\nset grid lc rgb '#dddddd' lt 1 lw 0.6\nset border lc rgb '#444444' lw "
      "0.8\nset tics nomirror textcolor rgb '#222222'\nset xtics autofreq\n";
  script += WayPanel(plot, view);
  const std::string time = plot.has_times ? "time [s]" : "pose";
  const ErrorKind ate{&PlotSeries::ate, "ate", "2", "ATE", "m", "mm"};
  const ErrorKind rpe{&PlotSeries::rpe, "rpe", "2", "RPE", "m", "mm"};
  const ErrorKind turn{&PlotSeries::rpe_rotation, "rpe", "3", "RPE", "deg", "mdeg"};
  script += ErrorPanel(plot, Place(0.93, 0.72), plot.ate_title, "", ate);
  script += ErrorPanel(plot, Place(0.58, 0.39), plot.rpe_title, "", rpe);
  script += ErrorPanel(plot, Place(0.33, 0.14), "", time, turn);
  return script + "unset multiplot\n";
}

}  // namespace planegraph
