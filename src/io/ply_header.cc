#include "io/ply_header.h"

#include <algorithm>
#include <map>

#include "io/cloud_formats.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

class PlyHeaderParser {
 public:
  PlyHeaderParser(std::string_view bytes, const std::string& file) : lines_(bytes), file_(file) {}

  PlyHeader Parse() {
    std::string_view line;
    if (!lines_.Next(&line) || Trim(line) != "ply") Fail("is not PLY: the first line is not 'ply'");
    while (lines_.Next(&line)) {
      const auto words = SplitWords(line);
      if (words.empty()) continue;
      if (words[0] == "end_header") return Finish();
      ParseLine(words, line);
    }
    Fail("the header has no end_header");
  }

 private:
  [[noreturn]] void Fail(const std::string& reason) {
    throw InputError::AtLine(file_, std::max<std::size_t>(1, lines_.number()), reason);
  }

  void ParseLine(const std::vector<std::string_view>& words, std::string_view line) {
    if (words[0] == "format") return ParseFormat(words);
    if (words[0] == "element") return ParseElement(words);
    if (words[0] == "property") return ParseProperty(words);
    if (words[0] == "comment") return ParseComment(Trim(line).substr(words[0].size()));
    if (words[0] != "obj_info") Fail("unknown header line " + Excerpt(line));
  }

  void ParseFormat(const std::vector<std::string_view>& words) {
    static const std::map<std::string, PlyEncoding, std::less<>> kEncodings = {
        {"ascii", PlyEncoding::kAscii},
        {"binary_little_endian", PlyEncoding::kLittleEndian},
        {"binary_big_endian", PlyEncoding::kBigEndian}};
    const auto found = words.size() < 2 ? kEncodings.end() : kEncodings.find(words[1]);
    if (found == kEncodings.end()) Fail("unknown PLY format");
    header_.encoding = found->second;
    has_format_ = true;
  }

  void ParseElement(const std::vector<std::string_view>& words) {
    long long count = 0;
    if (words.size() != 3 || !ParseInteger(words[2], &count))
      Fail("an element needs name and count");
    if (count < 0) Fail("the count " + std::string(words[2]) + " is negative");
    header_.elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(count), {}});
  }

  void ParseProperty(const std::vector<std::string_view>& words) {
    if (header_.elements.empty()) Fail("a property before any element");
    PlyProperty property;
    property.is_list = words.size() > 1 && words[1] == "list";
    if (words.size() != (property.is_list ? 5 : 3)) Fail("a property needs a type and a name");
    if (property.is_list) property.count_type = ParseType(words[2]);
    property.type = ParseType(words[words.size() - 2]);
    property.name = words.back();
    if (property.is_list && IsFloating(property.count_type))
      Fail("a list count must be an integer");
    header_.elements.back().properties.push_back(property);
  }

  ScalarType ParseType(std::string_view name) {
    static const std::map<std::string, ScalarType, std::less<>> kTypes = {
        {"char", ScalarType::kInt8},      {"int8", ScalarType::kInt8},
        {"uchar", ScalarType::kUint8},    {"uint8", ScalarType::kUint8},
        {"short", ScalarType::kInt16},    {"int16", ScalarType::kInt16},
        {"ushort", ScalarType::kUint16},  {"uint16", ScalarType::kUint16},
        {"int", ScalarType::kInt32},      {"int32", ScalarType::kInt32},
        {"uint", ScalarType::kUint32},    {"uint32", ScalarType::kUint32},
        {"int64", ScalarType::kInt64},    {"uint64", ScalarType::kUint64},
        {"float", ScalarType::kFloat32},  {"float32", ScalarType::kFloat32},
        {"double", ScalarType::kFloat64}, {"float64", ScalarType::kFloat64}};
    const auto found = kTypes.find(name);
    if (found == kTypes.end()) Fail("unknown type " + Excerpt(name));
    return found->second;
  }

  void ParseComment(std::string_view comment) {
    if (const auto v = ParseVectorComment(comment, "offset", file_, lines_.number())) {
      header_.offset = v;
    } else if (const auto w = ParseVectorComment(comment, "viewpoint", file_, lines_.number())) {
      header_.viewpoint = w;
    }
  }

  PlyHeader Finish() {
    if (!has_format_) Fail("the header has no format line");
    header_.body = lines_.position();
    header_.lines = lines_.number();
    return std::move(header_);
  }

  LineReader lines_;
  const std::string& file_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

bool PlyElement::HasLists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& property) { return property.is_list; });
}

std::size_t PlyElement::FixedBytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += property.is_list ? 0 : SizeOf(property.type);
  return bytes;
}

PlyHeader ParsePlyHeader(std::string_view bytes, const std::string& file) {
  return PlyHeaderParser(bytes, file).Parse();
}

std::optional<PlyHeader> ReadShortPlyHeader(std::istream* stream, const std::string& file) {
  constexpr std::size_t kMostBytes = 16384;
  std::string start(kMostBytes, '\0');
  stream->read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(stream->gcount()));
  stream->clear();
  if (!start.starts_with("ply\n") || start.find("\nend_header\n") == start.npos) return {};
  return ParsePlyHeader(start, file);
}

}  // namespace planegraph
