#pragma once

#include <functional>
#include <memory>
#include <string>

#include "planegraph/base/heartbeat.h"

namespace planegraph::tools {

/// Lines on stderr that a command is still at work, every ten seconds until the end of what is
/// returned; null with --quiet.
std::unique_ptr<Heartbeat> StartHeartbeat(const std::string& command);

using Progress = std::function<void(const std::string& stage, double done)>;

/// Where a command reports its stages to, from any thread: on a terminal they go to `draw`, which
/// draws one line over and over, elsewhere to the heartbeat's lines. Nowhere with --quiet.
Progress ProgressReporter(void (*draw)(const std::string& stage, double done));

/// A warning on stderr, in place of the line of progress that may be drawn there.
void PrintWarning(const std::string& text);

}  // namespace planegraph::tools
