#pragma once

#include <gflags/gflags_declare.h>

// Flags that every command takes.
DECLARE_int32(threads);
DECLARE_uint64(seed);
DECLARE_bool(json);
DECLARE_bool(quiet);
DECLARE_int32(log_level);
// Flags that several commands take.
DECLARE_string(output);
DECLARE_string(output_dir);
DECLARE_string(format);
DECLARE_double(min_range);
DECLARE_string(cameras);
DECLARE_string(gps);
DECLARE_string(image_times);
DECLARE_string(method);
