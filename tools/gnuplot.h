#pragma once

#include <string>

namespace planegraph::tools {

/// The format of a plot by its file's ending: "svg" or "pdf". Throws UsageError for another one,
/// and InputError where the program gnuplot is not installed.
std::string PlotFormat(const std::string& path);

/// Runs gnuplot on a script that draws to its standard output, and puts that into `path`,
/// atomically. Throws InputError.
void DrawPlot(const std::string& script, const std::string& path);

}  // namespace planegraph::tools
