// XYZ, TXT, CSV and 3DTK's .3d: text without a header that counts.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include "io/cloud_builder.h"
#include "io/cloud_formats.h"
#include "io/text_scanner.h"
#include "planegraph/base/error.h"

namespace planegraph {
namespace {

std::vector<double> NumbersOf(std::string_view line, char separator) {
  FieldReader fields(line, separator);
  std::vector<double> numbers;
  double number = 0.0;
  while (fields.Next(&number) == FieldReader::Result::kNumber) numbers.push_back(number);
  return numbers;
}

std::string_view WithoutCommentMark(std::string_view line) {
  line = Trim(line);
  while (!line.empty() && (line.front() == '#' || line.front() == '/')) line.remove_prefix(1);
  return Trim(line);
}

bool IsComment(std::string_view line) {
  line = Trim(line);
  return line.substr(0, 1) == "#" || line.substr(0, 2) == "//";
}

// The roles a line of names gives; empty where it names no x, y and z.
std::vector<Role> RolesOfNames(std::string_view line, char separator) {
  std::vector<Role> roles;
  for (const std::string_view name : SplitFields(line, separator))
    roles.push_back(RoleOfName(name));
  SkipRepeatedRoles(&roles);
  return RoleSet(roles).position ? roles : std::vector<Role>();
}

// Columns without names go by their number: 3 x y z; 4 and intensity; 6 and a unit normal, else
// colour; 7 and intensity, colour (.pts); 9 and colour, normal. Others count as x y z alone.
std::vector<Role> RolesOfNumbers(const std::vector<double>& row) {
  std::vector<Role> roles = {Role::kX, Role::kY, Role::kZ};
  const auto append = [&](std::initializer_list<Role> more) {
    for (const Role role : more) roles.push_back(role);
  };
  const std::size_t n = row.size();
  const bool unit = n == 6 && std::abs(std::hypot(row[3], row[4], row[5]) - 1.0) < 0.01;
  if (n == 4 || n == 7) append({Role::kIntensity});
  if (n == 7 || n == 9 || (n == 6 && !unit)) append({Role::kRed, Role::kGreen, Role::kBlue});
  if (n == 9 || unit) append({Role::kNormalX, Role::kNormalY, Role::kNormalZ});
  return roles;
}

class XyzParser {
 public:
  XyzParser(std::string_view bytes, const std::string& file)
      : bytes_(bytes), lines_(bytes), file_(file) {}

  Cloud Parse() {
    std::string_view line;
    while (lines_.Next(&line)) {
      if (Trim(line).empty()) continue;
      if (IsComment(line)) {
        ParseComment(WithoutCommentMark(line));
      } else if (!ParseHeader(line)) {
        return ParseBody(line);
      }
    }
    return Cloud();
  }

 private:
  // Also a comment may name the columns.
  void ParseComment(std::string_view comment) {
    const std::size_t number = lines_.number();
    if (const auto v = ParseVectorComment(comment, "offset", file_, number)) columns_.offset = v;
    if (const auto v = ParseVectorComment(comment, "viewpoint", file_, number)) viewpoint_ = *v;
    const auto roles = RolesOfNames(comment, SeparatorOf(comment));
    if (!roles.empty()) columns_.roles = roles;
  }

  // A line of names, or the number of points that .pts files start with.
  bool ParseHeader(std::string_view line) {
    const char separator = SeparatorOf(line);
    const auto numbers = NumbersOf(line, separator);
    if (numbers.size() == 1 && SplitFields(line, separator).size() == 1) return true;
    if (!numbers.empty() || !columns_.roles.empty()) return false;
    columns_.roles = RolesOfNames(line, separator);
    if (!columns_.roles.empty()) return true;
    throw InputError::AtLine(file_, lines_.number(),
                             "neither numbers nor names of columns x, y, z: " + Excerpt(line));
  }

  Cloud ParseBody(std::string_view line) {
    columns_.separator = SeparatorOf(line);
    if (columns_.roles.empty()) {
      columns_.roles = RolesOfNumbers(NumbersOf(line, columns_.separator));
    }
    Cloud cloud = BuildCloud(columns_, [&](CloudBuilder* builder) {
      LineReader left = lines_;
      std::string_view next = line;
      builder->Reserve((bytes_.size() - left.position()) / std::max<std::size_t>(6, line.size()));
      do {
        if (Trim(next).empty() || IsComment(next)) continue;
        builder->AddLine(next, file_, left.number());
      } while (left.Next(&next));
    });
    cloud.viewpoint = viewpoint_;
    return cloud;
  }

  std::string_view bytes_;
  LineReader lines_;
  const std::string& file_;
  TextColumns columns_;
  Eigen::Vector3d viewpoint_ = Eigen::Vector3d::Zero();
};

}  // namespace

Cloud ParseXyz(std::string_view bytes, const std::string& file) {
  return XyzParser(bytes, file).Parse();
}

Cloud Parse3dtkCloud(std::string_view bytes, const std::string& file) {
  constexpr std::size_t kMostHeaderLines = 10;
  LineReader lines(bytes);
  std::string_view line;
  while (lines.Next(&line)) {
    const auto numbers = NumbersOf(line, ' ');
    if (numbers.size() < 3) {
      if (lines.number() <= kMostHeaderLines) continue;
      throw InputError::AtLine(file, lines.number(), "is not a 3DTK point: " + Excerpt(line));
    }
    TextColumns columns;
    columns.is_3dtk = true;
    columns.roles = {Role::kX, Role::kY, Role::kZ};
    if (numbers.size() == 4) columns.roles.push_back(Role::kIntensity);
    return BuildCloud(columns, [&](CloudBuilder* builder) {
      LineReader left = lines;
      std::string_view next = line;
      builder->Reserve(bytes.size() / std::max<std::size_t>(6, line.size()));
      do {
        if (!Trim(next).empty()) builder->AddLine(next, file, left.number());
      } while (left.Next(&next));
    });
  }
  return Cloud();
}

}  // namespace planegraph
