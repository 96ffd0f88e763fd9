#include <cmath>

#include "io/file_bytes.h"
#include "io/text_scanner.h"
#include "io/trajectory_formats.h"
#include "planegraph/base/error.h"
#include "planegraph/io/trajectory_io.h"

namespace planegraph {

std::vector<double> ParseTimeStamps(std::string_view bytes, const std::string& file) {
  std::vector<double> times;
  LineReader lines(bytes);
  std::string_view line;
  while (lines.Next(&line)) {
    line = Trim(line);
    if (line.empty() || line.front() == '#') continue;
    double time = 0.0;
    const auto result = FieldReader(line, SeparatorOf(line)).Next(&time);
    if (result != FieldReader::Result::kNumber || !std::isfinite(time)) {
      throw InputError::AtLine(file, lines.number(),
                               "does not begin with a time in seconds: " + Excerpt(line));
    }
    times.push_back(time);
  }
  return times;
}

std::vector<double> ReadTimeStamps(const std::string& path) {
  return ParseTimeStamps(FileBytes(path).view(), path);
}

}  // namespace planegraph
