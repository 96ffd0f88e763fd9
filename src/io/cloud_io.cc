#include "planegraph/io/cloud_io.h"

#include <filesystem>
#include <map>
#include <utility>

#include "io/cloud_formats.h"
#include "io/file_bytes.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

constexpr std::pair<const char*, const char*> kFormats[] = {
    {".ply", "ply"}, {".pcd", "pcd"}, {".xyz", "xyz"}, {".txt", "xyz"},
    {".csv", "xyz"}, {".asc", "xyz"}, {".pts", "xyz"}, {".3d", "3dtk"}};

using Parser = Cloud (*)(std::string_view, const std::string&);

Parser ParserOf(const std::string& format) {
  static const std::map<std::string, Parser> kParsers = {
      {"ply", ParsePly}, {"pcd", ParsePcd}, {"xyz", ParseXyz}, {"3dtk", Parse3dtkCloud}};
  const auto found = kParsers.find(format);
  return found == kParsers.end() ? nullptr : found->second;
}

// The format that the first bytes give away; "" for plain text and the unknown.
std::string FormatOfContent(std::string_view bytes) {
  const std::string_view word = bytes.substr(0, bytes.find_first_of(" \r\n"));
  if (word == "ply") return "ply";
  if (bytes.substr(0, 6) == "# .PCD" || word == "VERSION") return "pcd";
  return "";
}

}  // namespace

std::string CloudEndings() {
  std::string list;
  for (const auto& [ending, format] : kFormats)
    list.append(list.empty() ? 0 : 1, ' ').append(ending);
  return list;
}

std::string CloudFormatOfEnding(const std::string& path) {
  const std::string own = ToLower(std::filesystem::path(path).extension().string());
  for (const auto& [ending, format] : kFormats) {
    if (own == ending) return format;
  }
  return "";
}

std::string ChooseCloudFormat(const std::string& path, const std::string& asked,
                              std::string_view bytes) {
  const std::string content = FormatOfContent(bytes);
  std::string format = asked == "auto" ? CloudFormatOfEnding(path) : asked;
  if (format.empty()) format = content;
  if (format.empty()) {
    throw InputError::InFile(path, "is no known cloud format (" + CloudEndings() +
                                       "); export .las, .e57 and others first: docs/your_data.md");
  }
  if (!content.empty() && content != format) {
    throw InputError::InFile(path, "holds " + content + ", not " + format);
  }
  return format;
}

Cloud ReadCloud(const std::string& path, const std::string& format) {
  if (format != "auto" && !ParserOf(format)) {
    throw UsageError("unknown cloud format '" + format + "' (auto, ply, pcd, xyz, 3dtk)");
  }
  const FileBytes file(path);
  if (file.view().empty()) throw InputError::InFile(path, "is empty");
  Cloud cloud = ParserOf(ChooseCloudFormat(path, format, file.view()))(file.view(), path);
  if (cloud.size() == 0) throw InputError::InFile(path, "holds no points (that are finite)");
  return cloud;
}

}  // namespace planegraph
