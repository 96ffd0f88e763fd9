#include "planegraph/solve/observability.h"

#include <cstdio>

namespace planegraph {

std::string Name(MotionKind kind) {
  switch (kind) {
    case MotionKind::kTranslation:
      return "translation";
    case MotionKind::kRotation:
      return "rotation";
    case MotionKind::kScale:
      return "scale";
    default:
      return "everything";
  }
}

std::string InWords(const OpenMotion& motion) {
  std::string words = Name(motion.kind);
  const std::string how = motion.kind == MotionKind::kRotation ? " about (" : " along (";
  for (std::size_t k = 0; k < motion.axes.size(); ++k) {
    char text[96];
    std::snprintf(text, sizeof(text), "%.2f, %.2f, %.2f)", motion.axes[k].x(), motion.axes[k].y(),
                  motion.axes[k].z());
    words += (k == 0 ? how : " and (") + text;
  }
  return words;
}

}  // namespace planegraph
