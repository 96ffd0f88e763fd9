// planegraph report: the HTML report of a finished run again.
#include <cstdio>

#include "planegraph/report/html_report.h"
#include "tools/command.h"

namespace planegraph::tools {
namespace {

int RunReport(const std::vector<std::string>& arguments) {
  ExpectArguments(arguments, 1, 1);
  WriteHtmlReport(arguments[0]);
  const std::string path = arguments[0] + "/report.html";
  EmitResult({{"report", path}}, false);
  if (WantsText()) std::printf("%s\n", path.c_str());
  return 0;
}

}  // namespace

Command ReportCommand() {
  return {"report", "DIR", "the HTML report of a finished run again", {}, RunReport};
}

}  // namespace planegraph::tools
