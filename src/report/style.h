#pragma once

namespace planegraph {

/// The report's style sheet: light, dark, phone and print.
extern const char* const kReportStyle;

}  // namespace planegraph
