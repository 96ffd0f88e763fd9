#pragma once

#include <string>
#include <string_view>

#include "planegraph/io/g2o_io.h"

namespace planegraph {

/// A whole g2o file in memory. Throws InputError.
G2oGraph ParseG2o(std::string_view bytes, const std::string& file);

}  // namespace planegraph
