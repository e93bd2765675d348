/* SPDX-License-Identifier: MIT */
#include <meshoptimizer.h>
#include <stdio.h>
#include <stdlib.h>

#include "runtime/slod.h"

/* What an engine does with a .slod: load, choose a level, decode its streams, pose it, draw its sections. */
int main(int argc, char** argv) {
  static unsigned char bytes[64 << 20];
  FILE* input = argc > 1 ? fopen(argv[1], "rb") : NULL;
  if (!input) return 2;
  const size_t size = fread(bytes, 1, sizeof bytes, input);
  fclose(input);

  slod_file file;
  const slod_status opened = slod_open(bytes, size, &file); /* everything is validated here, once */
  if (opened != SLOD_OK) return fprintf(stderr, "%s\n", slod_status_text(opened)), 3;

  /* 12 m away, on a screen of 1080 lines, an error of one pixel is fine. */
  const slod_view view = {.distance = 12, .projection_scale = 1.7f, .viewport_height = 1080,
                          .pixel_tolerance = 1, .hysteresis = 0.2f, .model_scale = 1};
  const uint32_t chosen = slod_select_level(&file, &view, SLOD_NONE);
  const slod_level level = slod_get_level(&file, chosen);

  /* A stream is a vertex or index buffer; its chunk tells format, scale and offset. */
  const slod_codecs codecs = {meshopt_decodeVertexBuffer, meshopt_decodeIndexBuffer};
  for (uint32_t c = level.first_chunk; c < level.first_chunk + level.chunk_count; ++c) {
    const slod_chunk chunk = slod_get_chunk(&file, c);
    const size_t buffer_size = (size_t)chunk.count * chunk.stride;
    void* buffer = malloc(buffer_size);
    const slod_status decoded = slod_decode(&file, c, &codecs, buffer, buffer_size);
    free(buffer); /* upload it */
    if (decoded != SLOD_OK) return fprintf(stderr, "%s\n", slod_status_text(decoded)), 3;
  }

  /* Each frame: the nodes' local matrices from your animation, here those at rest, become the palette. */
  float* nodes = malloc(12 * sizeof(float) * (slod_count(&file, SLOD_NODES) + 1));
  float* palette = malloc(12 * sizeof(float) * (slod_count(&file, SLOD_JOINTS) + 1));
  slod_rest_locals(&file, nodes);
  slod_globals(&file, nodes, nodes);
  slod_palette(&file, nodes, palette);

  uint32_t drawn = 0; /* a section is one draw call: one part, at most 256 joints */
  for (uint32_t s = level.first_section; s < level.first_section + level.section_count; ++s) {
    drawn += slod_get_section(&file, s).index_count / 3;
  }
  printf("LOD%u: %u triangles in %u draw calls\n", chosen, drawn, level.section_count);
  free(nodes);
  free(palette);
  return drawn == level.triangle_count ? 0 : 1;
}
