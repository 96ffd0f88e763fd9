#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace planegraph {

/// What is known of a process that has ended.
struct StageRecord {
  std::string key;  ///< of what it was made from
  std::vector<std::string> command;
  int exit_code = 0;
  std::string reason;
  double cpu_seconds = 0.0, wall_seconds = 0.0, peak_memory_bytes = 0.0;
};

/// A process that works in a folder: NAME.log takes what it says, NAME.record.json says that and
/// how it ended, so that it need not be started again.
struct Stage {
  std::string name, folder;
  std::vector<std::string> command;
  std::string key;
};

/// The record of a stage that has ended with the same key; nothing where it has to be done (again).
std::optional<StageRecord> FindRecord(const Stage& stage);

/// Starts the process, waits for its end and keeps the record, unless a signal ended it.
StageRecord RunStage(const Stage& stage);

}  // namespace planegraph
