#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace planegraph {

/// Unpacks an LZF stream (Lehmann's liblzf, the one PCL uses) of which the unpacked size is known.
/// Own code from the format: a control byte c < 32 starts c + 1 literal bytes; else c >> 5 is a
/// length (7: one more byte adds to it), the low 5 bits and the next byte a distance back, and
/// length + 2 bytes are copied. Throws InputError naming `file` where the stream leaves its bounds,
/// with the byte counted from `position`, the stream's place in the file.
std::vector<char> UnpackLzf(std::string_view packed, std::size_t unpacked_size,
                            const std::string& file, std::size_t position);

/// An LZF stream grows to at most this many times its size.
inline constexpr std::size_t kLzfLargestRatio = 88;

}  // namespace planegraph
