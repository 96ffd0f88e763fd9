#pragma once

#include "planegraph/cloud/cloud.h"

namespace planegraph {

/// Drops the points that some scanners return where nothing came back: a spike of points at the
/// very largest range with hardly any just before it. Keeps the order. No spike: nothing is
/// dropped.
Cloud DropSaturatedReturns(Cloud cloud);

/// Indices of the points that DropSaturatedReturns keeps, ascending.
std::vector<std::uint32_t> UnsaturatedReturns(const Cloud& cloud);

}  // namespace planegraph
