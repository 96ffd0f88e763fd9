#pragma once

#include <string>

#include "planegraph/io/cloud_writer.h"
#include "report/floor_plan.h"
#include "report/report_data.h"

namespace planegraph {

/// From metres on the page to the units of an SVG picture, with room for the axes' labels.
class PlanFrame {
 public:
  explicit PlanFrame(const PlanView& view, double most_height = 820);

  /// Of a world position.
  Eigen::Vector2d Place(const Eigen::Vector3d& position) const {
    return PlacePage(view_.OnPage(position.head<2>()));
  }
  Eigen::Vector2d PlacePage(const Eigen::Vector2d& page) const {
    return {kLeft + (page.x() - view_.low.x()) * scale_,
            kTop + (view_.high.y() - page.y()) * scale_};
  }
  double scale() const { return scale_; }  ///< units per metre
  double width() const { return width_; }  ///< of the drawing without the margins, units
  double height() const { return height_; }
  const PlanView& view() const { return view_; }

  static constexpr double kLeft = 44, kTop = 8, kRight = 12, kBottom = 30;

 private:
  PlanView view_;
  double scale_ = 1.0, width_ = 0.0, height_ = 0.0;
};

/// The map from above with scale bar, axes, way, scans, open directions and uncertainty ellipses,
/// with the legend; what a drone saw is the ground that it is drawn on. `map` may be empty.
std::string FloorPlanHtml(const ReportData& data, const MergedMap& map, const PlanFrame& frame);

/// The scans and the drone maps as nodes and the registrations as edges, over the faint map of
/// FloorPlanHtml on the same page, whose frame is `plan`.
std::string GraphHtml(const ReportData& data, const PlanFrame& plan);

}  // namespace planegraph
