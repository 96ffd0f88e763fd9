#include "report/floor_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "report/ground.h"

namespace planegraph {
namespace {

constexpr std::size_t kMostPlanPoints = 1500000;  ///< that are drawn of a map
constexpr std::size_t kMostViewPoints = 100000;
constexpr double kMostPlanPixels = 1.2e6;
constexpr double kLongestSide = 1600;
constexpr double kLeastPlanPixel = 0.05;  ///< metres; maps are thinned to about this

std::size_t Stride(const Cloud& map, std::size_t most) { return 1 + map.size() / most; }

// ---- view ----

struct Span {
  double low = 0.0, high = 0.0;
};

Span QuantileSpan(std::vector<double> values, double share) {
  const auto at = [&](double quantile) {
    const auto k = static_cast<std::ptrdiff_t>(quantile * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + k, values.end());
    return values[static_cast<std::size_t>(k)];
  };
  return {at(share), at(1.0 - share)};
}

// The span that holds all but `share` of the grid's filled cells at each end.
Span FilledSpan(const std::vector<double>& filled, Span span, double share) {
  const double most = share * std::accumulate(filled.begin(), filled.end(), 0.0);
  const double cell = (span.high - span.low) / static_cast<double>(filled.size());
  std::size_t first = 0, last = filled.size();
  for (double cut = filled[first]; cut < most; cut += filled[first]) ++first;
  for (double cut = filled[last - 1]; cut < most; cut += filled[last - 1]) --last;
  return {span.low + cell * static_cast<double>(first),
          span.low + cell * static_cast<double>(last)};
}

// Cuts off thin outskirts where they would take up much of the picture; else all but single points
// is shown.
Span WithoutOutskirts(const std::vector<double>& filled, Span span) {
  constexpr double kStray = 0.002, kOutskirts = 0.015, kMuch = 0.25;
  const Span outer = FilledSpan(filled, span, kStray);
  const Span inner = FilledSpan(filled, span, kOutskirts);
  const double much = kMuch * (inner.high - inner.low);
  return {inner.low - outer.low > much ? inner.low : outer.low,
          outer.high - inner.high > much ? inner.high : outer.high};
}

// Cells count by the root of their points: by the number alone the surroundings of the scanners
// would be all there is.
void TrimSpans(const std::vector<Eigen::Vector2d>& points, Span* across, Span* up) {
  constexpr int kCells = 200;
  constexpr int kLeastPoints = 3;
  const Eigen::Array2d low(across->low, up->low);
  const Eigen::Array2d cell =
      (Eigen::Array2d(across->high, up->high) - low).max(1e-6) / static_cast<double>(kCells);
  std::vector<int> counts(kCells * kCells, 0);
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Array2i at = ((p.array() - low) / cell).max(-1.0).min(kCells).floor().cast<int>();
    if ((at >= 0).all() && (at < kCells).all()) ++counts[at.y() * kCells + at.x()];
  }
  std::vector<double> columns(kCells, 0.0), rows(kCells, 0.0);
  for (int i = 0; i < kCells * kCells; ++i) {
    if (counts[i] < kLeastPoints) continue;
    columns[i % kCells] += std::sqrt(counts[i]);
    rows[i / kCells] += std::sqrt(counts[i]);
  }
  if (*std::max_element(columns.begin(), columns.end()) == 0.0) return;
  *across = WithoutOutskirts(columns, *across);
  *up = WithoutOutskirts(rows, *up);
}

std::vector<Eigen::Vector2d> SamplePage(const Cloud& map, const PlanView& view) {
  std::vector<Eigen::Vector2d> sample;
  const std::size_t stride = Stride(map, kMostViewPoints);
  for (std::size_t i = 0; i < map.size(); i += stride) {
    sample.push_back(view.OnPage(map.Position(i).head<2>()));
  }
  return sample;
}

void ShowPoints(const std::vector<Eigen::Vector2d>& points, PlanView* view) {
  if (points.empty()) return;
  std::vector<double> across, up;
  for (const Eigen::Vector2d& p : points) {
    across.push_back(p.x());
    up.push_back(p.y());
  }
  Span columns = QuantileSpan(std::move(across), 0.0005);
  Span rows = QuantileSpan(std::move(up), 0.0005);
  TrimSpans(points, &columns, &rows);
  view->low = view->low.cwiseMin(Eigen::Vector2d(columns.low, rows.low));
  view->high = view->high.cwiseMax(Eigen::Vector2d(columns.high, rows.high));
}

PlanView Fit(const Cloud& map, const std::vector<Eigen::Vector3d>& positions, bool turned) {
  PlanView view;
  view.turned = turned;
  view.low.setConstant(1e300);
  view.high.setConstant(-1e300);
  for (const Eigen::Vector3d& p : positions) {
    view.low = view.low.cwiseMin(view.OnPage(p.head<2>()));
    view.high = view.high.cwiseMax(view.OnPage(p.head<2>()));
  }
  ShowPoints(SamplePage(map, view), &view);
  if (!(view.low.array() <= view.high.array()).all()) view.low = view.high = {0.0, 0.0};
  const double margin = 0.02 * view.Extent().maxCoeff() + 0.5;
  view.low.array() -= margin;
  view.high.array() += margin;
  return view;
}

// ---- picture ----

// What a pixel saw, one bit for each layer of height above the ground.
constexpr int kLowLayers = 15;   ///< of 0.1 m from 0.3 m
constexpr int kHighLayers = 15;  ///< of 0.5 m from 1.8 m
constexpr double kLowest = 0.3, kLowLayer = 0.1, kHighest = 1.8, kHighLayer = 0.5;
constexpr std::uint32_t kLowMask = (1u << kLowLayers) - 1;
constexpr std::uint32_t kHighMask = ((1u << kHighLayers) - 1) << kLowLayers;
constexpr std::uint32_t kGround = 1u << 31;

std::uint32_t LayerOf(double height) {
  if (height < kLowest) return kGround;
  if (height < kHighest) return 1u << std::min(kLowLayers - 1, int((height - kLowest) / kLowLayer));
  const double layer = std::min((height - kHighest) / kHighLayer, kHighLayers - 1.0);
  return 1u << (kLowLayers + static_cast<int>(layer));
}

struct LayerGrid {
  std::size_t width = 0, height = 0;
  std::vector<std::uint32_t> layers;
};

LayerGrid EmptyGrid(const PlanView& view, double pixel) {
  LayerGrid grid;
  const Eigen::Array2d size = (view.Extent().array() / pixel).ceil().max(1.0);
  grid.width = static_cast<std::size_t>(size.x());
  grid.height = static_cast<std::size_t>(size.y());
  grid.layers.assign(grid.width * grid.height, 0);
  return grid;
}

LayerGrid SortIntoLayers(const Cloud& map, const PlanView& view) {
  const double pixel = PlanPixel(view);
  LayerGrid grid = EmptyGrid(view, pixel);
  const GroundModel ground(map, view);
  const std::size_t stride = Stride(map, kMostPlanPoints);
  for (std::size_t i = 0; i < map.size(); i += stride) {
    const Eigen::Vector3d p = map.Position(i);
    const Eigen::Vector2d page = view.OnPage(p.head<2>());
    const Eigen::Vector2d at = (page - view.low) / pixel;
    if (!(at.x() >= 0 && at.y() >= 0 && at.x() < double(grid.width) &&
          at.y() < double(grid.height))) {
      continue;
    }
    const std::size_t row = grid.height - 1 - static_cast<std::size_t>(at.y());
    grid.layers[row * grid.width + static_cast<std::size_t>(at.x())] |=
        LayerOf(p.z() - ground.Height(page));
  }
  return grid;
}

// The number of layers that a wall fills in this map: sparse maps are drawn as dark as dense ones.
int FullLayers(const LayerGrid& grid, std::uint32_t mask) {
  std::vector<std::size_t> counts(33, 0);
  std::size_t total = 0;
  for (const std::uint32_t layers : grid.layers) {
    if (layers == 0) continue;
    const int n = std::popcount(layers & mask);
    if (n < 2) continue;
    ++counts[n];
    ++total;
  }
  std::size_t below = 0;
  for (int n = 2; n < 33; ++n) {
    below += counts[n];
    if (below >= 0.8 * static_cast<double>(total)) return std::max(n, 3);
  }
  return 3;
}

// Palette: nothing, seen, then shades of upright things and of high things.
constexpr int kShades = 16;
constexpr std::uint8_t kNothing = 0, kSeen = 1, kUpright = 2, kHigh = 2 + kShades;

std::vector<Rgba> PlanPalette() {
  std::vector<Rgba> palette = {{255, 255, 255, 0}, {120, 130, 140, 40}};
  for (int i = 0; i < kShades; ++i) {
    const double t = (i + 1.0) / kShades;
    palette.push_back({20, 28, 40, static_cast<std::uint8_t>(60 + 195 * t)});
  }
  for (int i = 0; i < kShades; ++i) {
    const double t = (i + 1.0) / kShades;
    palette.push_back({40, 120, 110, static_cast<std::uint8_t>(60 + 130 * t)});
  }
  return palette;
}

// to[i] |= from[i] for i in [0, count). Plain pointers, so that the compiler can do many at a time.
void OrInto(const std::uint8_t* from, std::size_t count, std::uint8_t* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] |= from[i];
}

// Ones where there is a one or one of the four neighbours is.
std::vector<std::uint8_t> Grow(const std::vector<std::uint8_t>& in, std::size_t width) {
  std::vector<std::uint8_t> out = in;
  for (std::size_t row = 0; row < in.size(); row += width) {
    OrInto(in.data() + row, width - 1, out.data() + row + 1);
    OrInto(in.data() + row + 1, width - 1, out.data() + row);
  }
  OrInto(in.data(), in.size() - width, out.data() + width);
  OrInto(in.data() + width, in.size() - width, out.data());
  return out;
}

std::vector<std::uint8_t> Inverse(std::vector<std::uint8_t> flags) {
  for (std::uint8_t& flag : flags) flag ^= 1;
  return flags;
}

// Seen is also what lies between pixels that are: scan lines far from the scanner leave gaps. A
// morphological closing, so that nothing grows outwards.
std::vector<std::uint8_t> SeenPixels(const LayerGrid& grid) {
  constexpr int kReach = 3;
  static_assert(kNothing == 0 && kSeen == 1);
  std::vector<std::uint8_t> seen;
  seen.reserve(grid.layers.size());
  for (const std::uint32_t layers : grid.layers) seen.push_back(layers != 0 ? 1 : 0);
  for (int i = 0; i < kReach; ++i) seen = Grow(seen, grid.width);
  seen = Inverse(std::move(seen));
  for (int i = 0; i < kReach; ++i) seen = Grow(seen, grid.width);
  return Inverse(std::move(seen));
}

std::uint8_t Shade(int layers, int full) {
  const double t = std::min(1.0, static_cast<double>(layers) / full);
  return static_cast<std::uint8_t>(std::lround(std::pow(t, 0.6) * (kShades - 1)));
}

std::uint8_t ColourOf(std::uint32_t layers, int full_low, int full_high) {
  constexpr int kLeastUpright = 1, kLeastHigh = 3;
  if (layers == 0) return kNothing;
  const int low = std::popcount(layers & kLowMask), high = std::popcount(layers & kHighMask);
  if (high >= kLeastHigh && low < 3) return kHigh + Shade(high, full_high);
  if (low >= kLeastUpright) return kUpright + Shade(low - 1, full_low);
  return kSeen;
}

}  // namespace

PlanView ChooseView(const Cloud& map, const std::vector<Eigen::Vector3d>& positions,
                    bool is_east_north) {
  constexpr double kLongest = 1.25;  ///< up against across
  PlanView view = Fit(map, positions, false);
  view.north_up = is_east_north;
  if (is_east_north || view.Extent().y() <= kLongest * view.Extent().x()) return view;
  return Fit(map, positions, true);
}

double PlanPixel(const PlanView& view) {
  const Eigen::Vector2d extent = view.Extent();
  return std::max({kLeastPlanPixel, extent.maxCoeff() / kLongestSide,
                   std::sqrt(extent.prod() / kMostPlanPixels)});
}

FloorPlan DrawFloorPlan(const Cloud& map, const PlanView& view) {
  const LayerGrid grid = SortIntoLayers(map, view);
  const int full_low = FullLayers(grid, kLowMask), full_high = FullLayers(grid, kHighMask);
  FloorPlan plan;
  plan.palette = PlanPalette();
  plan.image.width = grid.width;
  plan.image.height = grid.height;
  plan.image.pixels = SeenPixels(grid);
  for (std::size_t i = 0; i < grid.layers.size(); ++i) {
    const std::uint8_t colour = ColourOf(grid.layers[i], full_low, full_high);
    if (colour != kNothing) plan.image.pixels[i] = colour;
  }
  return plan;
}

}  // namespace planegraph
