#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

namespace planegraph {

/// Count, sum and sum of outer products (xx xy xz yy yz zz) of points relative to some centre.
struct RawMoments {
  double count = 0.0;
  double sum[3] = {0, 0, 0};
  double square[6] = {0, 0, 0, 0, 0, 0};

  void Add(double x, double y, double z) {
    count += 1.0;
    sum[0] += x, sum[1] += y, sum[2] += z;
    square[0] += x * x, square[1] += x * y, square[2] += x * z;
    square[3] += y * y, square[4] += y * z, square[5] += z * z;
  }
  /// Adds moments about a centre that lies at `shift` from this one's.
  void AddShifted(const RawMoments& other, const Eigen::Vector3d& shift);
  Eigen::Vector3d Mean() const;
  /// Divided by the count, about the mean.
  Eigen::Matrix3d Covariance() const;
};

/// The points of one closed ball. Those of cells that lie inside as a whole are ranges of the
/// grid's arrays; the others are listed, relative to the ball's centre.
struct Neighbourhood {
  std::uint32_t index = 0;  ///< of the centre, in the cloud
  Eigen::Vector3f centre = Eigen::Vector3f::Zero();
  RawMoments moments;  ///< of all, about the centre
  std::vector<std::pair<std::uint32_t, std::uint32_t>> whole;
  std::vector<float> x, y, z;
  std::size_t listed = 0;  ///< entries of x, y, z in use

  std::size_t size() const { return static_cast<std::size_t>(moments.count); }
};

/// Points sorted by cells of a fraction of the radius, with the moments of each cell: a ball costs
/// the points of the cells on its surface and one addition for each cell inside.
class RadiusGrid {
 public:
  RadiusGrid(const std::vector<Eigen::Vector3f>& points, double radius);

  struct Cell {
    std::uint64_t key;    ///< z, y, x of 21 bits each: ascending along rows of x
    std::uint32_t begin;  ///< first point; the last cell is a sentinel
    Eigen::Vector3f low;  ///< bounds of its points
    Eigen::Vector3f high;
    RawMoments moments;  ///< about `low`
  };
  const std::vector<Cell>& cells() const { return cells_; }
  std::size_t cell_count() const { return cells_.size() - 1; }
  double radius() const { return radius_; }
  int reach() const { return reach_; }
  const std::vector<std::uint32_t>& order() const { return order_; }
  const std::vector<float>& x() const { return x_; }
  const std::vector<float>& y() const { return y_; }
  const std::vector<float>& z() const { return z_; }

 private:
  void Sort(const std::vector<Eigen::Vector3f>& points, double edge);
  void MakeCells();

  double radius_;
  int reach_ = 1;  ///< radius over edge of a cell
  std::vector<std::uint64_t> keys_;
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> order_;
  std::vector<float> x_, y_, z_;
};

/// Walks a range of cells and finds the balls around their points.
class RadiusSweep {
 public:
  RadiusSweep(const RadiusGrid& grid, std::size_t first_cell);
  /// Goes to `cell`, which must not lie before the last one.
  void MoveTo(std::size_t cell);
  /// The ball around the sorted point i of that cell.
  void Find(std::uint32_t i, Neighbourhood* out) const;

 private:
  void AddCell(const RadiusGrid::Cell& cell, std::uint32_t end, Neighbourhood* out) const;
  void AddListed(std::size_t first, Neighbourhood* out) const;

  const RadiusGrid& grid_;
  float surely_in_, surely_out_;      ///< squared distances; between them double decides
  std::vector<std::size_t> cursors_;  ///< per neighbouring row: the first cell not left behind
  std::vector<std::uint32_t> near_;   ///< occupied cells around the present one
};

}  // namespace planegraph
