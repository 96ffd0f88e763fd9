#pragma once

#include <string>

#include "io/test_files.h"
#include "planegraph/base/atomic_file.h"
#include "planegraph/io/cloud_io.h"
#include "planegraph/report/html_report.h"
#include "report/sample_run.h"

namespace planegraph {

// The page without the 3-D view's scripts, which a build may or may not have.
inline std::string WithoutScripts(std::string page) {
  for (std::size_t at; (at = page.find("<script type=")) != page.npos;) {
    page.erase(at, page.find("</script>", at) + 9 - at);
  }
  return page;
}

/// A folder with a report.json, and what is made of it.
class HtmlReport : public TestFolder {
 protected:
  std::string ReportOf(const std::string& json) {
    Write("report.json", json);
    WriteHtmlReport(Path(""));
    return WithoutScripts(ReadTextFile(Path("report.html")));
  }
  void WriteMap() { WriteCloud(Path("map.ply"), RoomCloud()); }
};

}  // namespace planegraph
