#pragma once

#include "planegraph/correspondence/xiao_matcher.h"
#include "planegraph/registration/closed_form.h"

namespace planegraph {

/// Registers two plane sets as the paper does: Xiao's search, then the closed form over all pairs
/// of the best solution. For comparison; it looks neither at free space nor at how much of the
/// surfaces agrees. `quality` is |K| / max(|P_target|, |P_source|) of the planes that take part,
/// `ambiguous` another pose (0.5 m or 5 degrees away) with as many pairs and 90 % of the area
/// product. Fewer than three pairs (two, where planes face in two directions only) are `failed`.
/// The refinement's `surfels` are zero; its `information` is the inverse of the covariance.
Registration RegisterXiao(const PlaneSet& target, const PlaneSet& source,
                          const XiaoOptions& options = {});

}  // namespace planegraph
