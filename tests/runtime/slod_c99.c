/* SPDX-License-Identifier: MIT */
#include "runtime/slod.h"

/* The header as a C program sees it; slod_test.cpp calls this and compares. */
int slod_c99_loads(const void* bytes, size_t size, uint32_t* triangles);

int slod_c99_loads(const void* bytes, size_t size, uint32_t* triangles) {
  slod_file file;
  slod_level level;
  if (slod_open(bytes, size, &file) != SLOD_OK) return 0;
  level = slod_get_level(&file, 0);
  *triangles = level.triangle_count;
  return sizeof(slod_header) == 40 && sizeof(slod_chunk) == 64 && sizeof(slod_level) == 104;
}
