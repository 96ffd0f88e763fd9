#pragma once

#include <map>
#include <string>

#include "planegraph/graph/factor_registry.h"
#include "planegraph/graph/loss.h"

namespace planegraph {

/// A loss for all factors, and others for some types of them.
struct FactorLosses {
  LossSpec general;
  std::map<std::string, LossSpec> by_type;  ///< by the name of the factor (`planegraph factors`)

  /// As ParseFactorLosses reads it.
  std::string ToString() const;
};

/// Reads LOSS[,FACTOR=LOSS...], each LOSS as ParseLoss does, say `cauchy:1,relative_pose=huber:2`.
/// The first part may be missing: then `general` is it. Throws UsageError for what is not so, for a
/// factor that does not exist (with the list of those that do), or one that is named twice.
FactorLosses ParseFactorLosses(const std::string& text, const LossSpec& general,
                               const FactorRegistry& factors);

/// Throws UsageError, with the list of the factors, for a name that none of them has.
void CheckFactorNames(const std::map<std::string, LossSpec>& by_type,
                      const FactorRegistry& factors);

}  // namespace planegraph
