#include "correspondence/direction_grid.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace planegraph {
namespace {

constexpr double kMostVoxels = 1 << 26;
// A surface counts for all classes within this angle: half the distance of two classes, and what a
// rotation may be off.
const double kClassReach = std::cos(35.0 * 3.14159265358979 / 180.0);

const std::array<Eigen::Vector3d, DirectionGrid::kClasses>& ClassDirections() {
  static const auto directions = [] {
    std::array<Eigen::Vector3d, DirectionGrid::kClasses> all;
    for (int k = 0, c = 0; k < 27; ++k) {
      if (k == 13) continue;
      all[c++] = Eigen::Vector3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).normalized();
    }
    return all;
  }();
  return directions;
}

std::vector<int> ClassesNear(const Eigen::Vector3d& normal) {
  std::vector<int> classes;
  for (int c = 0; c < DirectionGrid::kClasses; ++c) {
    if (ClassDirections()[c].dot(normal) > kClassReach) classes.push_back(c);
  }
  return classes;
}

// Where translations are tried: integer steps of the voxel from `first`.
struct Table {
  Eigen::Vector3i first, size;
  std::vector<std::uint8_t> counts;

  std::size_t Row(int y, int z) const {
    return (static_cast<std::size_t>(z) * size.y() + y) * size.x();
  }
};

// Eight bits as eight bytes, the lowest first.
const std::array<std::uint64_t, 256>& SpreadBits() {
  static const auto spread = [] {
    std::array<std::uint64_t, 256> all{};
    for (std::uint64_t bits = 0; bits < 256; ++bits) {
      for (int k = 0; k < 8; ++k) all[bits] |= (bits >> k & 1) << 8 * k;
    }
    return all;
  }();
  return spread;
}

// Adds each of the eight lowest bits to its count: no sum is carried into the next, since no more
// than 255 voters count.
void AddByte(std::uint64_t bits, std::uint8_t* to) {
  std::uint64_t counts;
  std::memcpy(&counts, to, 8);
  counts += SpreadBits()[bits & 255];
  std::memcpy(to, &counts, 8);
}

// Adds the map's voxels from `first` on to a row of the table, the inner loop of the vote: most of
// them are empty, and left by the word.
void AddRow(const std::uint64_t* row, int first, int count, std::uint8_t* to) {
  const int shift = first % 64;
  row += first / 64;
  for (int done = 0; done < count; done += 64, ++row) {
    std::uint64_t bits = row[0] >> shift;
    if (shift > 0) bits |= row[1] << (64 - shift);
    const int left = count - done;
    if (left < 64) bits &= (std::uint64_t{1} << left) - 1;
    for (std::uint8_t* at = to + done; bits != 0; bits >>= 8, at += 8) {
      if ((bits & 255) != 0) AddByte(bits, at);
    }
  }
}

// The count from which on at most `most` cells lie.
int Threshold(const std::vector<std::uint8_t>& counts, std::size_t most) {
  std::array<std::size_t, 256> histogram{};
  for (const std::uint8_t c : counts) ++histogram[c];
  std::size_t above = 0;
  for (int c = 255; c > 0; --c) {
    above += histogram[c];
    if (above > most) return c + 1;
  }
  return 1;
}

}  // namespace

int DirectionGrid::ClassOf(const Eigen::Vector3d& normal) {
  int best = 0;
  for (int c = 1; c < kClasses; ++c) {
    if (ClassDirections()[c].dot(normal) > ClassDirections()[best].dot(normal)) best = c;
  }
  return best;
}

DirectionGrid::DirectionGrid(const std::vector<Surfel>& surfels, double voxel) : voxel_(voxel) {
  if (surfels.empty()) return;
  Eigen::Vector3d low = surfels.front().mean, high = low;
  for (const Surfel& s : surfels) {
    low = low.cwiseMin(s.mean - Eigen::Vector3d::Constant(s.size));
    high = high.cwiseMax(s.mean + Eigen::Vector3d::Constant(s.size));
  }
  const Eigen::Vector3d extent = (high - low).array() + 2.0 * voxel;
  voxel_ = std::max(voxel, std::cbrt(extent.prod() / kMostVoxels));
  low_ = low.array() - voxel_;
  size_ = (extent / voxel_).array().ceil().cast<int>() + 1;
  for (const Surfel& s : surfels) Mark(s);
}

void DirectionGrid::Mark(const Surfel& s) {
  const std::vector<int> classes = ClassesNear(s.normal);
  const int steps = std::max(1, static_cast<int>(std::ceil(s.size / voxel_)));
  const Eigen::Vector3d across = s.normal.cross(s.axis1);
  for (int a = -steps; a <= steps; ++a) {
    for (int b = -steps; b <= steps; ++b) {
      const double u = 0.5 * s.size * a / steps, v = 0.5 * s.size * b / steps;
      for (const double off : {-0.5, 0.0, 0.5}) {
        MarkPoint(s.mean + u * s.axis1 + v * across + off * voxel_ * s.normal, classes);
      }
    }
  }
}

void DirectionGrid::MarkPoint(const Eigen::Vector3d& point, const std::vector<int>& classes) {
  const Eigen::Vector3i at = ((point - low_) / voxel_).array().floor().cast<int>();
  if (at.minCoeff() < 0 || (at - size_).maxCoeff() >= 0) return;
  for (const int c : classes) {
    if (layers_[c].empty()) {
      layers_[c].assign(Row(0, size_.z()), 0);
    }
    layers_[c][Row(at.y(), at.z()) + static_cast<std::size_t>(at.x()) / 64] |= std::uint64_t{1}
                                                                               << at.x() % 64;
  }
}

std::vector<DirectionGrid::Vote> DirectionGrid::Count(const std::vector<Voter>& voters,
                                                      const Window& window,
                                                      std::size_t most) const {
  constexpr std::size_t kMostVoters = 255;
  Table table;
  table.first = ((window.low - low_) / voxel_).array().floor().cast<int>();
  table.size = ((window.high - low_) / voxel_).array().floor().cast<int>();
  table.size = (table.size - table.first).cwiseMax(0).array() + 1;
  table.counts.assign(table.Row(0, table.size.z()) + 8, 0);  // eight are added at a time
  for (std::size_t k = 0; k < std::min(voters.size(), kMostVoters); ++k) {
    const auto& layer = layers_[voters[k].direction];
    if (layer.empty()) continue;
    const Eigen::Vector3i shift =
        (voters[k].place / voxel_).array().round().cast<int>() + table.first.array();
    // Cell t of the table stands for the map's voxel t + shift.
    const Eigen::Vector3i begin = (-shift).cwiseMax(0);
    const Eigen::Vector3i end = table.size.cwiseMin(size_ - shift);
    if (end.x() <= begin.x()) continue;
    for (int z = begin.z(); z < end.z(); ++z) {
      for (int y = begin.y(); y < end.y(); ++y) {
        AddRow(&layer[Row(y + shift.y(), z + shift.z())], begin.x() + shift.x(),
               end.x() - begin.x(), &table.counts[table.Row(y, z) + begin.x()]);
      }
    }
  }
  const int threshold = Threshold(table.counts, 16 * most);
  std::vector<Vote> votes;
  for (int z = 0; z < table.size.z(); ++z) {
    for (int y = 0; y < table.size.y(); ++y) {
      for (int x = 0; x < table.size.x(); ++x) {
        const int count = table.counts[table.Row(y, z) + x];
        if (count < threshold) continue;
        const Eigen::Vector3d cell = (Eigen::Vector3i(x, y, z) + table.first).cast<double>();
        votes.push_back({low_ + voxel_ * (cell.array() + 0.5).matrix(), count});
      }
    }
  }
  std::stable_sort(votes.begin(), votes.end(),
                   [](const Vote& a, const Vote& b) { return a.count > b.count; });
  std::vector<Vote> distinct;
  for (const Vote& vote : votes) {
    if (distinct.size() == most) break;
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Vote& d) {
      return (d.translation - vote.translation).cwiseAbs().maxCoeff() < 1.5 * voxel_;
    });
    if (!known) distinct.push_back(vote);
  }
  return distinct;
}

}  // namespace planegraph
