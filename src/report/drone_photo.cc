#include "report/drone_photo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace planegraph {
namespace {

constexpr double kMostPhotoPixels = 4e5;
constexpr double kLeastPhotoPixel = 0.08;  ///< metres
constexpr double kPointsPerPixel = 1.5;
constexpr int kFillRounds = 4;
constexpr double kTopLayer = 0.4;  ///< metres: points so near below the topmost one count

// Lightness and two differences of colour, each in about [0, 255]: a palette spends its entries
// better on them than on red, green and blue.
using Colour = std::array<float, 3>;

Colour FromRgb(const std::array<std::uint8_t, 3>& rgb) {
  const float r = rgb[0], g = rgb[1], b = rgb[2];
  return {0.299f * r + 0.587f * g + 0.114f * b, r - g, b - g};
}

Rgba Muted(const Colour& colour) {
  constexpr float kSaturation = 0.7f;
  const float first = kSaturation * colour[1], second = kSaturation * colour[2];
  const float green = colour[0] - 0.299f * first - 0.114f * second;
  const auto byte = [](float value) {
    return static_cast<std::uint8_t>(std::clamp(value, 0.0f, 255.0f));
  };
  return {byte(green + first), byte(green), byte(green + second), 255};
}

struct Photo {
  std::size_t width = 0, height = 0;
  std::vector<float> top;  ///< height of the topmost point
  std::vector<Colour> colours;
  std::vector<float> counts;
};

Photo EmptyPhoto(const PlanView& view, double pixel) {
  Photo photo;
  const Eigen::Array2d size = (view.Extent().array() / pixel).ceil().max(1.0);
  photo.width = static_cast<std::size_t>(size.x());
  photo.height = static_cast<std::size_t>(size.y());
  photo.top.assign(photo.width * photo.height, -std::numeric_limits<float>::infinity());
  photo.colours.assign(photo.top.size(), {});
  photo.counts.assign(photo.top.size(), 0.0f);
  return photo;
}

// Calls visit(point, pixel) for each point in the view.
template <typename Visit>
void ForEachInView(const Cloud& drone, const PlanView& view, double pixel, const Photo& photo,
                   const Visit& visit) {
  for (std::size_t i = 0; i < drone.size(); ++i) {
    const Eigen::Vector2d page = view.OnPage(drone.Position(i).head<2>());
    const Eigen::Vector2d at = (page - view.low) / pixel;
    if (!(at.x() >= 0 && at.y() >= 0 && at.x() < double(photo.width) &&
          at.y() < double(photo.height))) {
      continue;
    }
    const std::size_t row = photo.height - 1 - static_cast<std::size_t>(at.y());
    visit(i, row * photo.width + static_cast<std::size_t>(at.x()));
  }
}

std::size_t CountInView(const Cloud& drone, const PlanView& view) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < drone.size(); ++i) {
    const Eigen::Array2d page = view.OnPage(drone.Position(i).head<2>());
    count += (page >= view.low.array()).all() && (page < view.high.array()).all() ? 1 : 0;
  }
  return count;
}

Photo TakePhoto(const Cloud& drone, const PlanView& view, double pixel) {
  Photo photo = EmptyPhoto(view, pixel);
  ForEachInView(drone, view, pixel, photo, [&](std::size_t i, std::size_t at) {
    photo.top[at] = std::max(photo.top[at], drone.points[i].z());
  });
  ForEachInView(drone, view, pixel, photo, [&](std::size_t i, std::size_t at) {
    if (drone.points[i].z() < photo.top[at] - kTopLayer) return;
    const Colour colour = FromRgb(drone.colors[i]);
    for (int c = 0; c < 3; ++c) photo.colours[at][c] += colour[c];
    photo.counts[at] += 1.0f;
  });
  for (std::size_t at = 0; at < photo.counts.size(); ++at) {
    for (float& c : photo.colours[at]) c /= std::max(1.0f, photo.counts[at]);
  }
  return photo;
}

// Pixels without points between others that have some take their mean.
void FillHoles(Photo* photo) {
  constexpr float kLeastNeighbours = 4;
  const std::vector<float> counts = photo->counts;
  const auto width = static_cast<std::ptrdiff_t>(photo->width);
  for (std::size_t row = 1; row + 1 < photo->height; ++row) {
    for (std::size_t column = 1; column + 1 < photo->width; ++column) {
      const std::size_t at = row * photo->width + column;
      if (counts[at] > 0) continue;
      Colour sum{};
      float filled = 0;
      for (const std::ptrdiff_t step : {-width - 1, -width, -width + 1, std::ptrdiff_t(-1),
                                        std::ptrdiff_t(1), width - 1, width, width + 1}) {
        const auto other = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(at) + step);
        if (counts[other] == 0) continue;
        for (int c = 0; c < 3; ++c) sum[c] += photo->colours[other][c];
        ++filled;
      }
      if (filled < kLeastNeighbours) continue;
      for (int c = 0; c < 3; ++c) photo->colours[at][c] = sum[c] / filled;
      photo->counts[at] = 1;
    }
  }
}

// ---- palette ----

// Even steps between the quantiles of what a photo holds.
struct Channel {
  float low = 0.0f, step = 1.0f;
  int levels = 1;

  int Level(float value) const {
    return std::clamp(static_cast<int>((value - low) / step), 0, levels - 1);
  }
  float Value(int level) const { return low + step * (static_cast<float>(level) + 0.5f); }
};

Channel ChannelOf(const Photo& photo, std::size_t channel, int levels) {
  std::vector<float> values;
  for (std::size_t at = 0; at < photo.counts.size(); ++at) {
    if (photo.counts[at] > 0) values.push_back(photo.colours[at][channel]);
  }
  const auto quantile = [&](double share) {
    const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + k, values.end());
    return values[static_cast<std::size_t>(k)];
  };
  const float low = quantile(0.005), high = quantile(0.995);
  return {low, std::max(high - low, 1.0f) / static_cast<float>(levels), levels};
}

void Index(const Photo& photo, DronePhoto* picture) {
  const std::array<Channel, 3> channels = {ChannelOf(photo, 0, 15), ChannelOf(photo, 1, 4),
                                           ChannelOf(photo, 2, 4)};
  picture->palette = {{0, 0, 0, 0}};
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j < 4; ++j) {
      for (int k = 0; k < 4; ++k) {
        picture->palette.push_back(
            Muted({channels[0].Value(i), channels[1].Value(j), channels[2].Value(k)}));
      }
    }
  }
  picture->image = {photo.width, photo.height, std::vector<std::uint8_t>(photo.counts.size(), 0)};
  for (std::size_t at = 0; at < photo.counts.size(); ++at) {
    if (photo.counts[at] == 0) continue;
    int entry = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      entry = entry * channels[c].levels + channels[c].Level(photo.colours[at][c]);
    }
    picture->image.pixels[at] = static_cast<std::uint8_t>(1 + entry);
  }
}

}  // namespace

DronePhoto DrawDronePhoto(const Cloud& drone, const PlanView& view) {
  DronePhoto picture;
  if (drone.colors.empty()) return picture;
  const double shown = static_cast<double>(CountInView(drone, view));
  if (shown == 0.0) return picture;
  const double area = view.Extent().prod();
  picture.pixel = std::max({kLeastPhotoPixel, std::sqrt(area / kMostPhotoPixels),
                            std::sqrt(kPointsPerPixel * area / shown)});
  Photo photo = TakePhoto(drone, view, picture.pixel);
  for (int i = 0; i < kFillRounds; ++i) FillHoles(&photo);
  Index(photo, &picture);
  return picture;
}

}  // namespace planegraph
