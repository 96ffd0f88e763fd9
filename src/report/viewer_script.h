#pragma once

namespace planegraph {

/// The viewer of src/report/viewer with three.js, as one minified script that is generated at build
/// time; empty where the build had no Node.js.
extern const char* const kViewerScript;

}  // namespace planegraph
