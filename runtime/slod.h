/* SPDX-License-Identifier: MIT */
#pragma once

#include <stddef.h>
#include <stdint.h>

/* skinlod's runtime: loads, skins and switches the levels of detail of a rigged character.
 *
 * One header, one source. No heap, no exceptions, no global state, no dependency: the two decoders of
 * meshoptimizer are handed in. Nothing here blocks, prints or keeps a pointer to anything but the file's
 * bytes. Any number of threads may use one opened file.
 *
 *   slod_file file;
 *   if (slod_open(bytes, size, &file) != SLOD_OK) ...             // everything is validated here, once
 *   slod_level level = slod_get_level(&file, 2);
 *   for (uint32_t c = level.first_chunk; c < level.first_chunk + level.chunk_count; ++c) {
 *     slod_chunk chunk = slod_get_chunk(&file, c);                // its kind, and how many items of how many
 * bytes slod_decode(&file, c, &codecs, gpu_buffer[chunk.kind], (size_t)chunk.count * chunk.stride);
 *   }
 *
 * THE FILE, version 1. All numbers are little-endian, all floats finite IEEE 754 binary32, lengths in metres,
 * matrices three rows of four. The structs below are the bytes of the file.
 *
 *   slod_header
 *   slod_chunk [chunk_count]        the table: the shared chunks, then those of the levels, coarsest first
 *   shared chunks                   `head_bytes` end here: all that describes, and nothing that is bulk
 *   streams of the coarsest level
 *   ...
 *   streams of level 0              `file_bytes` end here
 *
 * Every chunk begins at a multiple of 16, directly after the one before it; the bytes between are 0. So a
 * prefix of the file that holds the head and k levels is usable: the k coarsest ones. Level 0 is the finest.
 * A reader passes over chunks of a kind that it does not know; any other change needs a new version.
 *
 * Versions: 1, the first. */

#ifdef __cplusplus
extern "C" {
#endif

enum {
  SLOD_VERSION = 1,
  SLOD_ENDIAN = 0x01020304,
  SLOD_ALIGNMENT = 16,
  SLOD_MAX_SECTION_JOINTS = 256,
  SLOD_MAX_INFLUENCES = 8,
  SLOD_MAX_SETS = 255 /* of uvs, and of colours */
};

/* No chunk, no level, no node... */
#define SLOD_NONE 0xffffffffu

typedef enum slod_status {
  SLOD_OK = 0,
  SLOD_NOT_SLOD,         /* does not begin with the magic */
  SLOD_OTHER_VERSION,    /* written in another version of the format */
  SLOD_OTHER_ENDIAN,     /* written for, or read on, a machine of the other byte order */
  SLOD_TRUNCATED,        /* shorter than it says, or than its head */
  SLOD_TRAILING_BYTES,   /* longer than it says */
  SLOD_BAD_CHECKSUM,     /* damaged */
  SLOD_BAD_TABLE,        /* a chunk is missing, or lies about its place or size */
  SLOD_BAD_RECORD,       /* a record refers to what is not there, or holds what it may not */
  SLOD_BAD_STREAM,       /* a stream does not decode, or decodes to indices or weights that are not legal */
  SLOD_LEVEL_ABSENT,     /* the prefix that was opened ends before this level */
  SLOD_NO_CODEC,         /* the stream is compressed and its decoder was not handed in */
  SLOD_BUFFER_TOO_SMALL, /* the caller's buffer */
  SLOD_BAD_ARGUMENT      /* a null pointer, or an index that is not there */
} slod_status;

/* A short English sentence without a full stop; never null. */
const char* slod_status_text(slod_status status);

/* "SLOD\r\n\x1a\n": a transfer that changes line ends is noticed at once. */
typedef struct slod_header {
  uint8_t magic[8];
  uint32_t version;
  uint32_t endian;
  uint64_t checksum; /* of the head's bytes after this field, by slod_checksum */
  uint32_t file_bytes;
  uint32_t head_bytes; /* header, table and shared chunks */
  uint32_t chunk_count;
  uint32_t chunk_stride; /* bytes of a table entry: 64 */
} slod_header;

/* What a chunk holds: an array of... The shared kinds lead the table, each once, in this order. */
typedef enum slod_kind {
  SLOD_NAMES = 0, /* UTF-8, each ended by a 0; records refer to a first byte; the character's own is at 0 */
  SLOD_NODES,     /* slod_node, every parent before its children */
  SLOD_MATRICES,  /* float[12]: rest matrices of nodes that are no product T R S */
  SLOD_JOINTS,    /* slod_joint */
  SLOD_MATERIALS, /* slod_material */
  SLOD_PARTS,     /* slod_part */
  SLOD_MORPHS,    /* slod_morph */
  SLOD_LEVELS,    /* slod_level, finest first */
  SLOD_SECTIONS,  /* slod_section, those of level 0 first */
  SLOD_SECTION_JOINTS, /* slod_section_joint, those of the first section first */
  SLOD_SHARED_KINDS,

  /* Streams of a level: an item a render vertex, but for the three from SLOD_INDEX on. A value is base + step
   * integer. */
  SLOD_POSITION = 32, /* uint16[4]: x y z 0 */
  SLOD_NORMAL,        /* int16[2]: octahedral, 32767 is 1 */
  SLOD_TANGENT,       /* int8[4]: octahedral in two, 127 is 1; handedness -127 or 127; 0 */
  SLOD_UV,            /* uint16[2]; `set` tells which */
  SLOD_COLOUR,        /* uint8[4]: linear rgba, 255 is 1; `set` tells which */
  SLOD_JOINT_INDEX,   /* uint8[4] or [8]: into the section's joints; 0 in unused slots */
  SLOD_WEIGHT,        /* uint8[4] or [8]: sum 255 at every vertex, heaviest first */
  SLOD_INDEX,       /* uint16 or uint32: three a triangle, counter-clockwise; 0 is the level's first vertex */
  SLOD_MORPH_RANGE, /* uint32: morph m has the offsets from range[m] up to range[m + 1] */
  SLOD_MORPH_OFFSET, /* slod_morph_offset */

  /* Of a level too, never compressed, read in place. */
  SLOD_GROUP,   /* vertices that follow the same joints: uint16[6], the box around them at rest for all morph
                 * weights from 0 to 1, lowest x y z and highest; uint16[influence_slots], the joints, first the
                 * one that all follow most; uint8[influence_slots], each one's largest weight, 255 is 1, 0 in
                 * unused slots */
  SLOD_CLIP_BOX /* slod_clip_box, one */
} slod_kind;

typedef enum slod_codec {
  SLOD_RAW = 0,
  SLOD_MESHOPT_VERTEX, /* meshopt_encodeVertexBuffer, version 0 */
  SLOD_MESHOPT_INDEX   /* meshopt_encodeIndexBuffer, version 1 */
} slod_codec;

typedef struct slod_chunk {
  uint32_t kind;
  uint32_t set;   /* of uvs or colours, else 0 */
  uint32_t level; /* SLOD_NONE for shared chunks */
  uint32_t codec;
  uint32_t offset; /* in the file */
  uint32_t bytes;  /* in the file */
  uint32_t count;  /* items, decoded */
  uint32_t stride; /* bytes an item, decoded */
  float base[4];   /* value = base + step * integer, each component by its own. */
  float step[4];   /* Of morph offsets, step[0..2] are for the position, step[3] is for the normal. */
} slod_chunk;

typedef struct slod_node {
  uint32_t name;
  int32_t parent;       /* a smaller index, or -1 */
  int32_t matrix;       /* the rest matrix, or -1: it is T R S */
  float translation[3]; /* at rest */
  float rotation[4];    /* x y z w */
  float scale[3];
} slod_node;

typedef struct slod_joint {
  uint32_t node;
  float inverse_bind[12]; /* the node's space from rest space */
} slod_joint;

enum { SLOD_DOUBLE_SIDED = 1 };

typedef struct slod_material {
  uint32_t name;
  uint32_t texture; /* the name of the base colour's image; may be empty */
  float base_colour[4];
  uint32_t flags;
} slod_material;

typedef struct slod_part {
  uint32_t name;
  int32_t node;        /* that carries the mesh, or -1 */
  int32_t material;    /* or -1 */
  uint8_t has_normal;  /* what the source had; */
  uint8_t has_tangent; /* the streams hold defaults for the rest */
  uint8_t uv_sets;
  uint8_t colour_sets;
} slod_part;

typedef struct slod_morph {
  uint32_t name;
  int32_t node;
  float weight; /* at rest */
} slod_morph;

/* Distances between a level and the source, posed: metres, over both directions and all poses. */
typedef struct slod_error {
  float rms;
  float max;
} slod_error;

typedef struct slod_level {
  uint32_t triangle_count;
  uint32_t vertex_count;
  uint32_t first_section;
  uint32_t section_count;
  uint32_t first_chunk;
  uint32_t chunk_count;
  uint64_t checksum;        /* of the bytes from its first chunk up to the next level's first */
  uint32_t max_influences;  /* no vertex has more */
  uint32_t influence_slots; /* 4 or 8, in the streams */
  slod_error examples;      /* over the poses that the cook solved for */
  slod_error unseen_clip;   /* over frames of the clips that it did not solve for */
  slod_error unseen_motion; /* over range-of-motion poses that it did not solve for */
  float box_min[3];         /* of the positions at rest */
  float box_max[3];
  float centre[3]; /* of a sphere around them */
  float radius;
} slod_level;

/* What is drawn with one call: triangles of one part, with vertices that no other section uses. A part may
 * have several, those of fewer influences first, where a shader that blends fewer matrices pays. */
typedef struct slod_section {
  uint32_t part;
  uint32_t first_index;
  uint32_t index_count;
  uint32_t first_vertex;
  uint32_t vertex_count;
  uint32_t first_joint;    /* in SLOD_SECTION_JOINTS */
  uint32_t joint_count;    /* 1 to 256 */
  uint32_t max_influences; /* no vertex of it has more: the first so many slots are enough */
} slod_section;

/* A joint that a section's vertices follow, and the box around those vertices in the space of the joint's
 * node, for all morph weights from 0 to 1. In any pose the section is inside the hull of the posed boxes. */
typedef struct slod_section_joint {
  uint32_t joint;
  float box_min[3];
  float box_max[3];
} slod_section_joint;

/* Around all vertices of a level, in the world, in all frames of the clips that were cooked with it (30 a
 * second) and for all morph weights from 0 to 1. */
typedef struct slod_clip_box {
  float box_min[3];
  float box_max[3];
} slod_clip_box;

typedef struct slod_morph_offset {
  uint32_t vertex;
  int16_t position[3];
  int16_t normal[3];
} slod_morph_offset;

/* XXH64 with seed 0, of little-endian words. */
uint64_t slod_checksum(const void* bytes, size_t size);

/* An opened file. Plain data that points into the caller's bytes, which must stay and not change. */
typedef struct slod_file {
  const uint8_t* bytes; /* need no alignment */
  uint32_t file_bytes;
  uint32_t chunk_count;
  uint32_t level_count;
  uint32_t first_level; /* the finest level that is there: 0 but for a prefix; level_count if none is */
  struct {
    uint32_t offset;
    uint32_t count;
  } shared[SLOD_SHARED_KINDS];
} slod_file;

/* Opens a whole file and validates all of it but the contents of the streams, which slod_decode validates.
 * On any status but SLOD_OK `file` is empty: it has no levels and no records. */
slod_status slod_open(const void* bytes, size_t size, slod_file* file);

/* The same for the first `size` bytes of a file, which must hold its head. `file->first_level` says which
 * levels are there. To go on, open again once more bytes have come. */
slod_status slod_open_prefix(const void* bytes, size_t size, slod_file* file);

/* How many bytes of the file must be there so that `level` and all coarser ones are. */
uint32_t slod_prefix_bytes(const slod_file* file, uint32_t level);

/* How many records of a shared kind there are; of SLOD_NAMES, bytes. */
uint32_t slod_count(const slod_file* file, slod_kind kind);

/* One record by value; all zero where there is none of that index. Cheap. */
slod_chunk slod_get_chunk(const slod_file* file, uint32_t index);
slod_node slod_get_node(const slod_file* file, uint32_t index);
slod_joint slod_get_joint(const slod_file* file, uint32_t index);
slod_material slod_get_material(const slod_file* file, uint32_t index);
slod_part slod_get_part(const slod_file* file, uint32_t index);
slod_morph slod_get_morph(const slod_file* file, uint32_t index);
slod_level slod_get_level(const slod_file* file, uint32_t index);
slod_section slod_get_section(const slod_file* file, uint32_t index);
slod_section_joint slod_get_section_joint(const slod_file* file, uint32_t index);

/* The name that a record refers to; "" where there is none. Lives as long as the file's bytes. */
const char* slod_name(const slod_file* file, uint32_t name);

/* The index of a level's chunk in the table, or SLOD_NONE. */
uint32_t slod_find(const slod_file* file, uint32_t level, slod_kind kind, uint32_t set);

/* meshoptimizer's decoders: {meshopt_decodeVertexBuffer, meshopt_decodeIndexBuffer}. */
typedef struct slod_codecs {
  int (*decode_vertices)(void* out, size_t count, size_t stride, const unsigned char* in, size_t size);
  int (*decode_indices)(void* out, size_t count, size_t stride, const unsigned char* in, size_t size);
} slod_codecs;

/* Decodes one stream of a level into `out`, of at least count * stride bytes, and validates it: indices stay
 * within their section's vertices, joints within its table, weights sum to 255. Reads `out` back, so let it
 * be ordinary memory. count * stride is never more than 64 times the chunk's bytes, whatever the file says.
 * SLOD_BAD_ARGUMENT for shared chunks, and for kinds that this loader does not know. */
slod_status slod_decode(const slod_file* file, uint32_t chunk, const slod_codecs* codecs, void* out,
                        size_t out_bytes);

/* Posing goes by these functions, in the order they stand; shaders/skinning.glsl agrees with them.
 *
 * The floats an item of the stream unpacks to: position 3, normal 3, tangent 4, uv 2, colour 4; else 0. */
uint32_t slod_components(const slod_chunk* chunk);

/* A decoded stream as floats, chunk->count times slod_components of them. Directions have unit length. */
void slod_unpack(const slod_chunk* chunk, const void* decoded, float* values);

/* Adds the morphs to unpacked positions and normals (may be null). `weights`: one a morph of the file. */
void slod_add_morphs(const slod_file* file, const slod_chunk* offsets_chunk, const uint32_t* ranges,
                     const slod_morph_offset* offsets, const float* weights, float* positions,
                     float* normals);

/* What a level needs of the skeleton: sets to 1 the joints that its vertices follow, and the nodes that these
 * hang on with all nodes above. A byte a joint, and a byte a node. What is 1 stays so: begin with 0 and the
 * nodes that something else hangs on, such as a weapon, and call it for each level that is shown. Only nodes
 * that are 1 then need to be animated and given to slod_globals; the joints of the rest move no vertex. Needs
 * only the head. */
void slod_needed(const slod_file* file, uint32_t level, uint8_t* joints, uint8_t* nodes);

/* The nodes' rest matrices in their parents' space: float[12] a node. */
void slod_rest_locals(const slod_file* file, float* locals);

/* From the nodes' matrices in their parents' space to those in the world. `globals` may be `locals`. */
void slod_globals(const slod_file* file, const float* locals, float* globals);

/* The joints' skinning matrices, world from rest space: float[12] a joint. */
void slod_palette(const slod_file* file, const float* globals, float* palette);

/* Linear blend skinning of a whole level, in place, with decoded joints and weights. `normals` may be null;
 * they are turned by the inverse transpose and come out with unit length. */
void slod_skin(const slod_file* file, uint32_t level, const uint8_t* joints, const uint8_t* weights,
               const float* palette, float* positions, float* normals);

/* A box around the level as slod_skin poses it by these nodes, whatever they are: no vertex is read. From the
 * level's groups where it is there and has them, else from the boxes of its joints, which are in the head: a
 * much looser box. */
void slod_posed_bounds(const slod_file* file, uint32_t level, const float* globals, float box_min[3],
                       float box_max[3]);

/* A box around the level in all of its clips, for culling before anything is posed. 0 where the level is not
 * there or was cooked without clips: then nothing is written. */
int slod_clip_bounds(const slod_file* file, uint32_t level, float box_min[3], float box_max[3]);

typedef struct slod_view {
  float distance;         /* from the eye to the nearest point of the character's bounds, metres */
  float projection_scale; /* [1][1] of the projection matrix: 1 / tan(vertical field of view / 2) */
  float viewport_height;  /* pixels */
  float pixel_tolerance;  /* how large an error may look; 1 is a good start */
  float hysteresis;  /* the part of the tolerance by which an error must pass it to switch: 0.1 to 0.25 */
  float model_scale; /* of the character in the world */
} slod_view;

/* How large, in pixels, the level's largest measured error over example poses and clips looks from there. */
float slod_pixel_error(const slod_file* file, uint32_t level, const slod_view* view);

/* The coarsest level that is there and whose error stays within the tolerance, or the finest that is there.
 * `current` is the level now shown, or SLOD_NONE; it stays until its error is above the tolerance by the
 * hysteresis, or a coarser level's is below by as much. SLOD_NONE where no level is there. */
uint32_t slod_select_level(const slod_file* file, const slod_view* view, uint32_t current);

#ifdef __cplusplus
}
#endif
