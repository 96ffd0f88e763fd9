#include "io/pcd_header.h"

#include <algorithm>
#include <map>

#include "io/cloud_formats.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

using Words = std::vector<std::string_view>;

class PcdHeaderParser {
 public:
  PcdHeaderParser(std::string_view bytes, const std::string& file) : lines_(bytes), file_(file) {}

  PcdHeader Parse() {
    std::string_view line;
    while (lines_.Next(&line)) {
      const Words words = SplitWords(line);
      if (words.empty()) continue;
      if (words[0].front() == '#') {
        ParseComment(Trim(line).substr(1));
        continue;
      }
      if (!entries_.count(words[0]) && words[0] != "DATA") {
        Fail("is not a PCD header line: " + Excerpt(line));
      }
      if (words[0] == "DATA") return Finish(words);
      entries_.find(words[0])->second = {Words(words.begin() + 1, words.end()), lines_.number()};
    }
    Fail("the PCD header has no DATA line");
  }

 private:
  struct Entry {
    Words values;
    std::size_t line = 0;  // 0: absent
  };

  [[noreturn]] void Fail(const std::string& reason) {
    throw InputError::AtLine(file_, std::max<std::size_t>(1, lines_.number()), reason);
  }
  [[noreturn]] void FailAt(const Entry& entry, const std::string& reason) {
    throw InputError::AtLine(file_, std::max<std::size_t>(1, entry.line), reason);
  }

  void ParseComment(std::string_view comment) {
    if (const auto v = ParseVectorComment(comment, "offset", file_, lines_.number())) {
      header_.offset = v;
    }
  }

  PcdHeader Finish(const Words& words) {
    static const std::map<std::string, PcdData, std::less<>> kData = {
        {"ascii", PcdData::kAscii},
        {"binary", PcdData::kBinary},
        {"binary_compressed", PcdData::kCompressed}};
    const auto found = words.size() == 2 ? kData.find(words[1]) : kData.end();
    if (found == kData.end()) Fail("DATA must be ascii, binary or binary_compressed");
    header_.data = found->second;
    ParseFields();
    header_.points = CountPoints();
    ParseViewpoint();
    header_.body = lines_.position();
    header_.lines = lines_.number();
    return std::move(header_);
  }

  const Entry& FieldsEntry() { return entries_[entries_["FIELDS"].line ? "FIELDS" : "COLUMNS"]; }

  void ParseFields() {
    const Entry& names = FieldsEntry();
    const Entry &sizes = entries_["SIZE"], &types = entries_["TYPE"], &counts = entries_["COUNT"];
    if (names.values.empty()) FailAt(names, "the header has no FIELDS");
    const std::size_t n = names.values.size();
    for (const Entry* entry : {&sizes, &types}) {
      if (entry->values.size() != n) FailAt(*entry, "SIZE and TYPE need one value per field");
    }
    if (counts.line && counts.values.size() != n) FailAt(counts, "COUNT needs one value per field");
    for (std::size_t i = 0; i < n; ++i) {
      PcdField field;
      field.name = names.values[i];
      field.type = ParseType(types, types.values[i], sizes.values[i]);
      if (counts.line) field.count = ParseCount(counts, counts.values[i]);
      header_.fields.push_back(field);
    }
  }

  ScalarType ParseType(const Entry& entry, std::string_view type, std::string_view size) {
    static const std::map<std::string, ScalarType> kTypes = {
        {"F4", ScalarType::kFloat32}, {"F8", ScalarType::kFloat64}, {"I1", ScalarType::kInt8},
        {"I2", ScalarType::kInt16},   {"I4", ScalarType::kInt32},   {"I8", ScalarType::kInt64},
        {"U1", ScalarType::kUint8},   {"U2", ScalarType::kUint16},  {"U4", ScalarType::kUint32},
        {"U8", ScalarType::kUint64}};
    const auto found = kTypes.find(std::string(type) + std::string(size));
    if (found == kTypes.end()) {
      FailAt(entry, "unknown field type " + Excerpt(type) + " of size " + Excerpt(size));
    }
    return found->second;
  }

  std::size_t ParseCount(const Entry& entry, std::string_view word) {
    constexpr long long kMost = 1000000;
    long long count = 0;
    if (!ParseInteger(word, &count) || count < 0 || count > kMost) {
      FailAt(entry, "a COUNT of " + Excerpt(word) + " values is not possible");
    }
    return static_cast<std::size_t>(count);
  }

  // WIDTH, HEIGHT or POINTS; -1 where the line is absent.
  long long Number(const std::string& key) {
    const Entry& entry = entries_[key];
    if (!entry.line) return -1;
    long long value = 0;
    if (entry.values.size() != 1 || !ParseInteger(entry.values[0], &value)) {
      FailAt(entry, key + " needs one number");
    }
    if (value < 0) FailAt(entry, key + " is negative");
    return value;
  }

  std::uint64_t CountPoints() {
    const long long width = Number("WIDTH"), height = Number("HEIGHT"), points = Number("POINTS");
    if (width < 0 && points < 0) Fail("the header has neither WIDTH nor POINTS");
    if (width < 0) return static_cast<std::uint64_t>(points);
    const auto w = static_cast<std::uint64_t>(width);
    const auto h = static_cast<std::uint64_t>(height < 0 ? 1 : height);
    if (h > 0 && w > (std::uint64_t{1} << 62) / h)
      FailAt(entries_["WIDTH"], "WIDTH * HEIGHT is absurd");
    if (points >= 0 && static_cast<std::uint64_t>(points) != w * h) {
      FailAt(entries_["POINTS"], "POINTS is not WIDTH * HEIGHT");
    }
    return w * h;
  }

  void ParseViewpoint() {
    const Entry& entry = entries_["VIEWPOINT"];
    if (!entry.line) return;
    if (entry.values.size() != 7) FailAt(entry, "VIEWPOINT needs 7 numbers");
    for (int axis = 0; axis < 3; ++axis) {
      double& value = header_.viewpoint[axis];
      if (!ParseNumber(entry.values[static_cast<std::size_t>(axis)], &value)) {
        FailAt(entry, "VIEWPOINT needs 7 numbers");
      }
    }
    if (!header_.viewpoint.allFinite()) header_.viewpoint.setZero();
  }

  LineReader lines_;
  const std::string& file_;
  PcdHeader header_;
  std::map<std::string, Entry, std::less<>> entries_ = {
      {"VERSION", {}}, {"FIELDS", {}}, {"COLUMNS", {}}, {"SIZE", {}},   {"TYPE", {}},
      {"COUNT", {}},   {"WIDTH", {}},  {"HEIGHT", {}},  {"POINTS", {}}, {"VIEWPOINT", {}}};
};

}  // namespace

std::size_t PcdHeader::PointBytes() const {
  std::size_t bytes = 0;
  for (const PcdField& field : fields) bytes += field.Bytes();
  return bytes;
}

std::size_t PcdHeader::PointValues() const {
  std::size_t values = 0;
  for (const PcdField& field : fields) values += field.count;
  return values;
}

PcdHeader ParsePcdHeader(std::string_view bytes, const std::string& file) {
  return PcdHeaderParser(bytes, file).Parse();
}

}  // namespace planegraph
