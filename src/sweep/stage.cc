#include "sweep/stage.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "planegraph/base/atomic_file.h"
#include "planegraph/base/error.h"
#include "sweep/child_process.h"

namespace planegraph {
namespace {

using Json = nlohmann::json;

std::string RecordFile(const Stage& stage) {
  return stage.folder + "/" + stage.name + ".record.json";
}
std::string LogFile(const Stage& stage) { return stage.folder + "/" + stage.name + ".log"; }

StageRecord FromJson(const Json& json) {
  StageRecord record;
  record.key = json.at("key");
  record.command = json.at("command").get<std::vector<std::string>>();
  record.exit_code = json.at("exit_code");
  record.reason = json.at("reason");
  record.cpu_seconds = json.at("cpu_seconds");
  record.wall_seconds = json.at("wall_seconds");
  record.peak_memory_bytes = json.at("peak_memory_bytes");
  return record;
}

Json ToJson(const StageRecord& record) {
  return {{"key", record.key},
          {"command", record.command},
          {"exit_code", record.exit_code},
          {"reason", record.reason},
          {"cpu_seconds", record.cpu_seconds},
          {"wall_seconds", record.wall_seconds},
          {"peak_memory_bytes", record.peak_memory_bytes}};
}

// Of a log, the last line `error: ...`, or the last one at all.
std::string LastError(const std::string& log) {
  static const std::string kMark = "error: ";
  std::istringstream stream(log);
  std::string last, error;
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind(kMark, 0) == 0) error = line.substr(kMark.size());
    if (!line.empty()) last = line;
  }
  return error.empty() ? last : error;
}

std::string Reason(const ChildResult& child, const std::string& log) {
  if (child.exit_code == 0) return "";
  if (child.signal > 0) return "ended by signal " + std::to_string(child.signal);
  const std::string error = LastError(ReadTextFile(log));
  return error.empty() ? "it says nothing" : error;
}

}  // namespace

std::optional<StageRecord> FindRecord(const Stage& stage) {
  const std::string path = RecordFile(stage);
  if (!std::filesystem::exists(path)) return {};
  try {
    StageRecord record = FromJson(Json::parse(ReadTextFile(path)));
    if (record.key == stage.key) return record;
  } catch (const Json::exception&) {
    // A record that cannot be read is none.
  }
  return {};
}

StageRecord RunStage(const Stage& stage) {
  std::error_code ignored;
  std::filesystem::remove(RecordFile(stage), ignored);
  const ChildResult child = RunChild(stage.command, LogFile(stage));
  StageRecord record{
      stage.key,         stage.command,      child.exit_code,        Reason(child, LogFile(stage)),
      child.cpu_seconds, child.wall_seconds, child.peak_memory_bytes};
  if (child.signal == 0) WriteTextFile(RecordFile(stage), ToJson(record).dump(1) + "\n");
  return record;
}

}  // namespace planegraph
