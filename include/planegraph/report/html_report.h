#pragma once

#include <string>

namespace planegraph {

/// Writes FOLDER/report.html from FOLDER/report.json and FOLDER/map.ply, atomically: verdict, floor
/// plan with the way and the scans' uncertainty, tables of scans and registrations, graph, errors
/// against a reference, solve, times and configuration. One file without references to others, that
/// needs no JavaScript. Any value may be missing from report.json and is then shown as a dash; a
/// missing map.ply leaves the picture without a map. Equal input gives equal bytes. Throws
/// InputError where report.json is missing or no JSON object, or map.ply is not a valid cloud.
void WriteHtmlReport(const std::string& folder);

}  // namespace planegraph
