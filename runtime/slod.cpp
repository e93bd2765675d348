// SPDX-License-Identifier: MIT
#include "runtime/slod.h"

#include <math.h>
#include <string.h>

// Reading goes through memcpy: the caller's bytes need no alignment, and no pointer of a wrong type is made.
// Sizes are added and multiplied in 64 bits, so that no lie in 32 bits can overflow them.

static_assert(sizeof(slod_header) == 40);
static_assert(sizeof(slod_chunk) == 64);
static_assert(sizeof(slod_node) == 52);
static_assert(sizeof(slod_joint) == 52);
static_assert(sizeof(slod_material) == 28);
static_assert(sizeof(slod_part) == 16);
static_assert(sizeof(slod_morph) == 12);
static_assert(sizeof(slod_level) == 104);
static_assert(sizeof(slod_section) == 32);
static_assert(sizeof(slod_section_joint) == 28);
static_assert(sizeof(slod_morph_offset) == 16);
static_assert(sizeof(slod_clip_box) == 24);
static_assert(sizeof(float) == 4);

namespace {

template <class T>
T load(const uint8_t* from) {
  T value;
  memcpy(&value, from, sizeof value);
  return value;
}

template <class T>
T load(const void* array, size_t index) {
  return load<T>(static_cast<const uint8_t*>(array) + index * sizeof(T));
}

template <class T>
T record(const slod_file& file, slod_kind kind, uint32_t index) {
  if (index >= file.shared[kind].count) return T{};
  return load<T>(file.bytes + file.shared[kind].offset, index);
}

uint64_t aligned(uint64_t offset) { return (offset + SLOD_ALIGNMENT - 1) / SLOD_ALIGNMENT * SLOD_ALIGNMENT; }

// By bits, so that it holds under -ffast-math too.
bool finite(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return (bits & 0x7f800000) != 0x7f800000;
}

template <int N>
bool finite(const float (&values)[N]) {
  for (const float value : values) {
    if (!finite(value)) return false;
  }
  return true;
}

constexpr uint64_t kPrime[5] = {0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9,
                                0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5};

uint64_t rotate(uint64_t x, int bits) { return x << bits | x >> (64 - bits); }

uint64_t mix(uint64_t lane, uint64_t word) { return rotate(lane + word * kPrime[1], 31) * kPrime[0]; }

// Bytes an item of the shared kinds.
constexpr uint32_t kRecordBytes[SLOD_SHARED_KINDS] = {1,
                                                      sizeof(slod_node),
                                                      12 * sizeof(float),
                                                      sizeof(slod_joint),
                                                      sizeof(slod_material),
                                                      sizeof(slod_part),
                                                      sizeof(slod_morph),
                                                      sizeof(slod_level),
                                                      sizeof(slod_section),
                                                      sizeof(slod_section_joint)};

constexpr uint32_t kGroupBox = 6 * sizeof(uint16_t);  // of a group's bytes; the rest are 3 a slot

bool known_stream(uint32_t kind) { return kind >= SLOD_POSITION && kind <= SLOD_CLIP_BOX; }

// Neither codec can say more in fewer bytes: a vertex block spends at least 2 bits on each 16 bytes, an index
// buffer a byte on each triangle. So a lie about `count` cannot make the caller allocate without limit.
bool valid_codec(const slod_chunk& c) {
  const uint64_t decoded = uint64_t(c.count) * c.stride;
  switch (c.codec) {
    case SLOD_RAW:
      return decoded == c.bytes;
    case SLOD_MESHOPT_VERTEX:
      return c.kind != SLOD_INDEX && c.kind < SLOD_GROUP && c.stride % 4 == 0 && c.stride <= 256 &&
             decoded <= 64 * uint64_t(c.bytes);
    case SLOD_MESHOPT_INDEX:
      return c.kind == SLOD_INDEX && c.count % 3 == 0 && c.count / 3 <= c.bytes;
    default:
      return false;
  }
}

bool valid_stream_stride(const slod_chunk& c) {
  switch (c.kind) {
    case SLOD_POSITION:
      return c.stride == 8;
    case SLOD_JOINT_INDEX:
    case SLOD_WEIGHT:
      return c.stride == 4 || c.stride == SLOD_MAX_INFLUENCES;
    case SLOD_INDEX:
      return c.stride == 2 || c.stride == 4;
    case SLOD_MORPH_OFFSET:
      return c.stride == sizeof(slod_morph_offset);
    case SLOD_GROUP:
      return c.stride == kGroupBox + 3 * 4 || c.stride == kGroupBox + 3 * SLOD_MAX_INFLUENCES;
    case SLOD_CLIP_BOX:
      return c.stride == sizeof(slod_clip_box);
    default:
      return c.stride == 4;
  }
}

bool valid_shared_chunk(const slod_chunk& c, uint32_t index) {
  if (c.codec != SLOD_RAW || uint64_t(c.count) * c.stride != c.bytes) return false;
  if (index < SLOD_SHARED_KINDS) return c.kind == index && c.stride == kRecordBytes[index];
  return c.kind >= SLOD_SHARED_KINDS && !known_stream(c.kind);
}

bool valid_stream_chunk(const slod_chunk& c) {
  if (c.kind < SLOD_SHARED_KINDS || c.count == 0 || c.bytes == 0 || !finite(c.base) || !finite(c.step)) {
    return false;
  }
  if (!known_stream(c.kind)) return true;
  const uint32_t sets = c.kind == SLOD_UV || c.kind == SLOD_COLOUR ? SLOD_MAX_SETS : 1;
  return valid_codec(c) && valid_stream_stride(c) && c.set < sets;
}

// The table: the shared chunks fill the head, the levels' the rest, without a gap or an overlap.
bool open_table(slod_file& file, uint32_t head_bytes) {
  uint64_t end = sizeof(slod_header) + uint64_t(file.chunk_count) * sizeof(slod_chunk);
  if (file.chunk_count < SLOD_SHARED_KINDS || end > head_bytes) return false;

  bool shared = true;
  for (uint32_t i = 0; i < file.chunk_count; ++i) {
    const slod_chunk c = slod_get_chunk(&file, i);
    if (shared && c.level != SLOD_NONE) {
      if (i < SLOD_SHARED_KINDS || aligned(end) != head_bytes) return false;
      shared = false;
    }
    if (c.offset != aligned(end)) return false;
    end = uint64_t(c.offset) + c.bytes;
    if (end > (shared ? head_bytes : file.file_bytes)) return false;
    if (shared ? !valid_shared_chunk(c, i) : c.level == SLOD_NONE || !valid_stream_chunk(c)) return false;
    if (i < SLOD_SHARED_KINDS) file.shared[i] = {c.offset, c.count};
  }
  file.level_count = file.shared[SLOD_LEVELS].count;
  return !shared && aligned(end) == file.file_bytes;
}

// A chunk of `level` whose kind is known, that is there at most once, and of the right length.
bool valid_level_chunk(const slod_file& file, uint32_t index, uint32_t level_index, const slod_level& level) {
  const slod_chunk c = slod_get_chunk(&file, index);
  if (c.level != level_index) return false;
  if (!known_stream(c.kind)) return true;
  if (slod_find(&file, level_index, slod_kind(c.kind), c.set) != index) return false;
  switch (c.kind) {
    case SLOD_INDEX:
      return c.count == 3 * uint64_t(level.triangle_count);
    case SLOD_JOINT_INDEX:
    case SLOD_WEIGHT:
      return c.count == level.vertex_count && c.stride == level.influence_slots;
    case SLOD_MORPH_RANGE:
      return c.count == uint64_t(slod_count(&file, SLOD_MORPHS)) + 1;
    case SLOD_MORPH_OFFSET:
      return slod_find(&file, level_index, SLOD_MORPH_RANGE, 0) != SLOD_NONE;
    case SLOD_GROUP:
      return c.stride == kGroupBox + 3 * level.influence_slots;
    case SLOD_CLIP_BOX:
      return c.count == 1;
    default:
      return c.count == level.vertex_count;
  }
}

bool has_stream(const slod_file& file, uint32_t level, slod_kind kind) {
  return slod_find(&file, level, kind, 0) != SLOD_NONE;
}

// How much of the lists of sections, their joints, and chunks the levels have used up: they must leave
// nothing over, so each list has one order only and nothing is in two places.
struct Used {
  uint32_t sections, section_joints, chunk;
};

bool valid_section(const slod_file& file, const slod_section& s, const slod_level& level) {
  return s.part < slod_count(&file, SLOD_PARTS) && s.index_count > 0 && s.index_count % 3 == 0 &&
         s.vertex_count > 0 && s.joint_count > 0 && s.joint_count <= SLOD_MAX_SECTION_JOINTS &&
         s.max_influences > 0 && s.max_influences <= level.max_influences;
}

bool valid_level(const slod_file& file, uint32_t index, Used& used) {
  const slod_level level = slod_get_level(&file, index);
  const slod_error errors[] = {level.examples, level.unseen_clip, level.unseen_motion};
  for (const slod_error& e : errors) {
    if (!finite({e.rms, e.max}) || e.rms < 0 || e.max < 0) return false;
  }
  if (!finite(level.box_min) || !finite(level.box_max) || !finite(level.centre) || !finite(level.radius)) {
    return false;
  }
  if (level.influence_slots > SLOD_MAX_INFLUENCES || level.max_influences > level.influence_slots) {
    return false;
  }
  if (level.triangle_count == 0 || level.triangle_count > SLOD_NONE / 3) return false;

  // Sums of 32-bit counts that may lie: in 64 bits they cannot wrap before the lists end.
  uint64_t vertices = 0, indices = 0;
  if (level.first_section != used.sections ||
      uint64_t(level.first_section) + level.section_count > slod_count(&file, SLOD_SECTIONS)) {
    return false;
  }
  for (uint32_t i = 0; i < level.section_count; ++i) {
    const slod_section s = slod_get_section(&file, used.sections++);
    if (!valid_section(file, s, level)) return false;
    if (s.first_vertex != vertices || s.first_index != indices || s.first_joint != used.section_joints) {
      return false;
    }
    if (uint64_t(s.first_joint) + s.joint_count > slod_count(&file, SLOD_SECTION_JOINTS)) return false;
    vertices += s.vertex_count, indices += s.index_count, used.section_joints += s.joint_count;
  }
  return vertices == level.vertex_count && indices == 3 * uint64_t(level.triangle_count);
}

// Apart from `valid_level` because levels refer to chunks in the file's order, coarsest first.
bool valid_streams(const slod_file& file, uint32_t index, Used& used) {
  const slod_level level = slod_get_level(&file, index);
  if (level.first_chunk != used.chunk || uint64_t(used.chunk) + level.chunk_count > file.chunk_count) {
    return false;
  }
  for (uint32_t i = 0; i < level.chunk_count; ++i) {
    if (!valid_level_chunk(file, used.chunk++, index, level)) return false;
  }
  return has_stream(file, index, SLOD_POSITION) && has_stream(file, index, SLOD_JOINT_INDEX) &&
         has_stream(file, index, SLOD_WEIGHT) && has_stream(file, index, SLOD_INDEX) &&
         has_stream(file, index, SLOD_MORPH_RANGE) == has_stream(file, index, SLOD_MORPH_OFFSET);
}

bool valid_name(const slod_file& file, uint32_t name) { return name < slod_count(&file, SLOD_NAMES); }

// -1 or an index.
bool valid_reference(const slod_file& file, int32_t index, slod_kind kind) {
  return index >= -1 && (index == -1 || uint32_t(index) < slod_count(&file, kind));
}

bool valid_records(const slod_file& file) {
  const auto count = [&](slod_kind kind) { return slod_count(&file, kind); };
  if (count(SLOD_NAMES) == 0 || record<char>(file, SLOD_NAMES, count(SLOD_NAMES) - 1) != 0) return false;

  for (uint32_t i = 0; i < count(SLOD_NODES); ++i) {
    const slod_node n = slod_get_node(&file, i);
    if (!valid_name(file, n.name) || n.parent < -1 || n.parent >= int64_t(i)) return false;
    if (!valid_reference(file, n.matrix, SLOD_MATRICES)) return false;
    if (!finite(n.translation) || !finite(n.rotation) || !finite(n.scale)) return false;
  }
  struct Matrix {
    float rows[12];
  };
  for (uint32_t i = 0; i < count(SLOD_MATRICES); ++i) {
    if (!finite(record<Matrix>(file, SLOD_MATRICES, i).rows)) return false;
  }
  for (uint32_t i = 0; i < count(SLOD_JOINTS); ++i) {
    const slod_joint j = slod_get_joint(&file, i);
    if (j.node >= count(SLOD_NODES) || !finite(j.inverse_bind)) return false;
  }
  for (uint32_t i = 0; i < count(SLOD_MATERIALS); ++i) {
    const slod_material m = slod_get_material(&file, i);
    if (!valid_name(file, m.name) || !valid_name(file, m.texture) || !finite(m.base_colour)) return false;
  }
  for (uint32_t i = 0; i < count(SLOD_PARTS); ++i) {
    const slod_part p = slod_get_part(&file, i);
    if (!valid_name(file, p.name) || !valid_reference(file, p.node, SLOD_NODES)) return false;
    if (!valid_reference(file, p.material, SLOD_MATERIALS)) return false;
  }
  for (uint32_t i = 0; i < count(SLOD_MORPHS); ++i) {
    const slod_morph m = slod_get_morph(&file, i);
    if (!valid_name(file, m.name) || !valid_reference(file, m.node, SLOD_NODES) || !finite(m.weight)) {
      return false;
    }
  }
  for (uint32_t i = 0; i < count(SLOD_SECTION_JOINTS); ++i) {
    const slod_section_joint j = slod_get_section_joint(&file, i);
    if (j.joint >= count(SLOD_JOINTS) || !finite(j.box_min) || !finite(j.box_max)) return false;
  }
  return true;
}

bool valid_levels(const slod_file& file) {
  Used used = {0, 0, 0};
  while (used.chunk < file.chunk_count && slod_get_chunk(&file, used.chunk).level == SLOD_NONE) ++used.chunk;
  for (uint32_t i = 0; i < file.level_count; ++i) {
    if (!valid_level(file, i, used)) return false;
  }
  for (uint32_t i = file.level_count; i-- > 0;) {
    if (!valid_streams(file, i, used)) return false;
  }
  return used.sections == slod_count(&file, SLOD_SECTIONS) && used.chunk == file.chunk_count &&
         used.section_joints == slod_count(&file, SLOD_SECTION_JOINTS);
}

slod_status open_head(const uint8_t* bytes, size_t size, slod_file& file) {
  slod_header header = {};
  memcpy(&header, bytes, size < sizeof header ? size : sizeof header);
  const size_t seen = size < sizeof header.magic ? size : sizeof header.magic;
  if (memcmp(header.magic, "SLOD\r\n\x1a\n", seen) != 0) return SLOD_NOT_SLOD;
  if (size < sizeof header) return SLOD_TRUNCATED;
  if (header.endian != SLOD_ENDIAN) return SLOD_OTHER_ENDIAN;
  if (header.version != SLOD_VERSION) return SLOD_OTHER_VERSION;
  if (header.head_bytes < sizeof header || header.head_bytes > header.file_bytes) return SLOD_BAD_TABLE;
  if (size < header.head_bytes) return SLOD_TRUNCATED;
  if (size > header.file_bytes) return SLOD_TRAILING_BYTES;
  const size_t covered = offsetof(slod_header, file_bytes);
  if (slod_checksum(bytes + covered, header.head_bytes - covered) != header.checksum) {
    return SLOD_BAD_CHECKSUM;
  }
  if (header.chunk_stride != sizeof(slod_chunk)) return SLOD_BAD_TABLE;

  file.bytes = bytes, file.file_bytes = header.file_bytes, file.chunk_count = header.chunk_count;
  if (!open_table(file, header.head_bytes)) return SLOD_BAD_TABLE;
  if (!valid_records(file) || !valid_levels(file)) return SLOD_BAD_RECORD;
  return SLOD_OK;
}

// A chunk of a level that is there; else one of no items.
slod_chunk chunk_in_place(const slod_file& file, uint32_t level, slod_kind kind) {
  return level < file.first_level ? slod_chunk{} : slod_get_chunk(&file, slod_find(&file, level, kind, 0));
}

// An item of SLOD_GROUP.
struct Group {
  float box_min[3], box_max[3];
  uint32_t joint[SLOD_MAX_INFLUENCES], joint_count;
  float weight[SLOD_MAX_INFLUENCES];
};

Group group_at(const slod_file& file, const slod_chunk& chunk, uint32_t index) {
  const uint8_t* const item = file.bytes + chunk.offset + size_t(index) * chunk.stride;
  const uint32_t slots = (chunk.stride - kGroupBox) / 3;
  Group group = {};
  for (uint32_t k = 0; k < 3; ++k) {
    group.box_min[k] = chunk.base[k] + chunk.step[k] * float(load<uint16_t>(item, k));
    group.box_max[k] = chunk.base[k] + chunk.step[k] * float(load<uint16_t>(item, k + 3));
  }
  const uint8_t* const joints = item + kGroupBox;
  for (uint32_t k = 0; k < slots && (k == 0 || joints[2 * slots + k] > 0); ++k, ++group.joint_count) {
    group.joint[k] = load<uint16_t>(joints, k);
    group.weight[k] = float(joints[2 * slots + k]) / 255;
  }
  return group;
}

bool valid_boxes(const slod_file& file, uint32_t level) {
  const slod_chunk groups = chunk_in_place(file, level, SLOD_GROUP);
  for (uint32_t i = 0; i < groups.count; ++i) {
    const Group g = group_at(file, groups, i);
    for (uint32_t k = 0; k < g.joint_count; ++k) {
      if (g.joint[k] >= slod_count(&file, SLOD_JOINTS)) return false;
    }
  }
  const slod_chunk clips = chunk_in_place(file, level, SLOD_CLIP_BOX);
  if (clips.count == 0) return true;
  const auto box = load<slod_clip_box>(file.bytes + clips.offset);
  return finite(box.box_min) && finite(box.box_max);
}

// Levels whose bytes are all there, from the coarsest on; `file.first_level` ends at the finest of them.
slod_status open_levels(size_t size, slod_file& file) {
  for (file.first_level = file.level_count; file.first_level > 0; --file.first_level) {
    const slod_level level = slod_get_level(&file, file.first_level - 1);
    const uint32_t begin = slod_get_chunk(&file, level.first_chunk).offset;
    const uint32_t end = slod_prefix_bytes(&file, file.first_level - 1);
    if (end > size) break;
    if (slod_checksum(file.bytes + begin, end - begin) != level.checksum) return SLOD_BAD_CHECKSUM;
  }
  for (uint32_t level = file.first_level; level < file.level_count; ++level) {
    if (!valid_boxes(file, level)) return SLOD_BAD_RECORD;
  }
  return SLOD_OK;
}

uint32_t index_at(const slod_chunk& c, const void* decoded, uint32_t i) {
  return c.stride == 2 ? load<uint16_t>(decoded, i) : load<uint32_t>(decoded, i);
}

bool valid_indices(const slod_chunk& c, const slod_section& s, const void* decoded) {
  for (uint32_t i = s.first_index; i < s.first_index + s.index_count; ++i) {
    if (index_at(c, decoded, i) - s.first_vertex >= s.vertex_count) return false;
  }
  return true;
}

bool valid_joints(const slod_chunk& c, const slod_section& s, const uint8_t* joints) {
  const size_t begin = size_t(s.first_vertex) * c.stride, end = begin + size_t(s.vertex_count) * c.stride;
  for (size_t i = begin; i < end; ++i) {
    if (joints[i] >= s.joint_count) return false;
  }
  return true;
}

bool valid_weights(const slod_chunk& c, const slod_section& s, const uint8_t* weights) {
  for (uint32_t v = s.first_vertex; v < s.first_vertex + s.vertex_count; ++v) {
    const uint8_t* w = weights + size_t(v) * c.stride;
    uint32_t sum = w[0], used = 1;
    for (uint32_t i = 1; i < c.stride; ++i) {
      if (w[i] > w[i - 1]) return false;
      sum += w[i], used += w[i] > 0;
    }
    if (sum != 255 || used > s.max_influences) return false;
  }
  return true;
}

bool valid_ranges(const slod_file& file, const slod_chunk& c, const void* ranges) {
  const slod_chunk offsets = slod_get_chunk(&file, slod_find(&file, c.level, SLOD_MORPH_OFFSET, 0));
  for (uint32_t m = 0; m + 1 < c.count; ++m) {
    if (load<uint32_t>(ranges, m) > load<uint32_t>(ranges, m + 1)) return false;
  }
  return load<uint32_t>(ranges, 0) == 0 && load<uint32_t>(ranges, c.count - 1) == offsets.count;
}

bool valid_offsets(const slod_file& file, const slod_chunk& c, const void* offsets) {
  const uint32_t vertices = slod_get_level(&file, c.level).vertex_count;
  for (uint32_t i = 0; i < c.count; ++i) {
    if (load<slod_morph_offset>(offsets, i).vertex >= vertices) return false;
  }
  return true;
}

bool valid_stream(const slod_file& file, const slod_chunk& c, const void* decoded) {
  if (c.kind == SLOD_MORPH_RANGE) return valid_ranges(file, c, decoded);
  if (c.kind == SLOD_MORPH_OFFSET) return valid_offsets(file, c, decoded);
  const slod_level level = slod_get_level(&file, c.level);
  for (uint32_t i = 0; i < level.section_count; ++i) {
    const slod_section s = slod_get_section(&file, level.first_section + i);
    if (c.kind == SLOD_INDEX && !valid_indices(c, s, decoded)) return false;
    if (c.kind == SLOD_JOINT_INDEX && !valid_joints(c, s, static_cast<const uint8_t*>(decoded))) return false;
    if (c.kind == SLOD_WEIGHT && !valid_weights(c, s, static_cast<const uint8_t*>(decoded))) return false;
  }
  return true;
}

void normalise(float* v) {
  const float length = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  if (!(length > 0)) return;
  for (int i = 0; i < 3; ++i) v[i] /= length;
}

// Meyer et al. 2010, "On Floating-Point Normal Vectors": the octahedron's lower half is folded outwards.
void unfold_octahedron(float x, float y, float* direction) {
  const float z = 1 - fabsf(x) - fabsf(y);
  const float fold = z < 0 ? -z : 0;
  direction[0] = x + (x < 0 ? fold : -fold);
  direction[1] = y + (y < 0 ? fold : -fold);
  direction[2] = z;
  normalise(direction);
}

// Matrices are three rows of four.
void compose(const float* a, const float* b, float* ab) {
  for (int r = 0; r < 3; ++r) {
    const float* row = a + 4 * r;
    for (int c = 0; c < 4; ++c) {
      ab[4 * r + c] = row[0] * b[c] + row[1] * b[4 + c] + row[2] * b[8 + c] + (c == 3 ? row[3] : 0);
    }
  }
}

void transform(const float* m, const float* x, float* y) {
  for (int r = 0; r < 3; ++r, m += 4) y[r] = m[0] * x[0] + m[1] * x[1] + m[2] * x[2] + m[3];
}

// The cofactors are the inverse transpose times the determinant, and defined where that is not.
void turn_normal(const float* m, float* n) {
  float cofactor[9];
  for (int r = 0; r < 3; ++r) {
    const float *a = m + 4 * ((r + 1) % 3), *b = m + 4 * ((r + 2) % 3);
    cofactor[3 * r] = a[1] * b[2] - a[2] * b[1];
    cofactor[3 * r + 1] = a[2] * b[0] - a[0] * b[2];
    cofactor[3 * r + 2] = a[0] * b[1] - a[1] * b[0];
  }
  const float determinant = m[0] * cofactor[0] + m[1] * cofactor[1] + m[2] * cofactor[2];
  const float side = determinant < 0 ? -1.0f : 1.0f;
  const float from[3] = {n[0] * side, n[1] * side, n[2] * side};
  for (int r = 0; r < 3; ++r) {
    n[r] = cofactor[3 * r] * from[0] + cofactor[3 * r + 1] * from[1] + cofactor[3 * r + 2] * from[2];
  }
  normalise(n);
}

// Skinning and these boxes are in floats: a posed vertex may be off by so much of the sizes that were added
// up.
constexpr float kRounding = 1.0f / (1 << 18);

// Where one row of a matrix takes a box: from `low` to `high`, adding up numbers of at most `size`.
struct Extent {
  float low, high, size;
};

Extent extent(const float* row, const float* box_min, const float* box_max) {
  Extent e = {row[3], row[3], fabsf(row[3])};
  for (int k = 0; k < 3; ++k) {
    const float a = row[k] * box_min[k], b = row[k] * box_max[k];
    e.low += a < b ? a : b, e.high += a < b ? b : a;
    e.size += fabsf(a) > fabsf(b) ? fabsf(a) : fabsf(b);
  }
  return e;
}

struct PosedBox {
  float low[3], high[3];
  bool any;
};

void add(PosedBox& box, int axis, float low, float high) {
  if (!box.any || low < box.low[axis]) box.low[axis] = low;
  if (!box.any || high > box.high[axis]) box.high[axis] = high;
}

// With T_b the joints' matrices, a the heaviest joint and x at rest, a posed vertex is
//   sum_b w_b T_b x = T_a x + sum_b w_b (T_b - T_a) x.
// So along each axis it is no farther than the farthest T_b x, and no farther than T_a x and the largest
// weights times what pulls outwards: both hold, and the nearer one counts.
void add_group(const slod_file& file, const Group& group, const float* globals, PosedBox& box) {
  float heaviest[12], other[12];
  const auto skinning_matrix = [&](uint32_t joint, float* m) {
    const slod_joint j = slod_get_joint(&file, joint);
    compose(globals + 12 * size_t(j.node), j.inverse_bind, m);
  };
  skinning_matrix(group.joint[0], heaviest);
  Extent hull[3], pulled[3];
  for (int r = 0; r < 3; ++r) hull[r] = pulled[r] = extent(heaviest + 4 * r, group.box_min, group.box_max);
  for (uint32_t k = 1; k < group.joint_count; ++k) {
    skinning_matrix(group.joint[k], other);
    for (int r = 0; r < 3; ++r) {
      const Extent alone = extent(other + 4 * r, group.box_min, group.box_max);
      if (alone.low < hull[r].low) hull[r].low = alone.low;
      if (alone.high > hull[r].high) hull[r].high = alone.high;
      if (alone.size > hull[r].size) hull[r].size = alone.size;
      for (int c = 0; c < 4; ++c) other[4 * r + c] -= heaviest[4 * r + c];
      const Extent pull = extent(other + 4 * r, group.box_min, group.box_max);
      if (pull.low < 0) pulled[r].low += group.weight[k] * pull.low;
      if (pull.high > 0) pulled[r].high += group.weight[k] * pull.high;
    }
  }
  for (int r = 0; r < 3; ++r) {
    const float slack = kRounding * hull[r].size;
    add(box, r, (hull[r].low > pulled[r].low ? hull[r].low : pulled[r].low) - slack,
        (hull[r].high < pulled[r].high ? hull[r].high : pulled[r].high) + slack);
  }
  box.any = true;
}

void rest_local(const slod_file& file, const slod_node& node, float* local) {
  if (node.matrix >= 0) {
    memcpy(local, file.bytes + file.shared[SLOD_MATRICES].offset + size_t(node.matrix) * 48, 48);
    return;
  }
  const float x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
  const float square = x * x + y * y + z * z + w * w;
  const float s = square > 0 ? 2 / square : 0;
  const float rotation[9] = {1 - s * (y * y + z * z), s * (x * y - z * w),     s * (x * z + y * w),
                             s * (x * y + z * w),     1 - s * (x * x + z * z), s * (y * z - x * w),
                             s * (x * z - y * w),     s * (y * z + x * w),     1 - s * (x * x + y * y)};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) local[4 * r + c] = rotation[3 * r + c] * node.scale[c];
    local[4 * r + 3] = node.translation[r];
  }
}

// The coarsest level that is there and stays within `tolerance`, else the finest that is there.
uint32_t coarsest_within(const slod_file& file, const slod_view& view, float tolerance) {
  for (uint32_t level = file.level_count; level-- > file.first_level;) {
    if (slod_pixel_error(&file, level, &view) <= tolerance) return level;
  }
  return file.first_level;
}

}  // namespace

extern "C" {

const char* slod_status_text(slod_status status) {
  switch (status) {
    case SLOD_OK:
      return "no error";
    case SLOD_NOT_SLOD:
      return "this is not a .slod file";
    case SLOD_OTHER_VERSION:
      return "the file has a format version that this loader does not read";
    case SLOD_OTHER_ENDIAN:
      return "the file and this machine differ in byte order";
    case SLOD_TRUNCATED:
      return "the file ends too early";
    case SLOD_TRAILING_BYTES:
      return "the file goes on after its end";
    case SLOD_BAD_CHECKSUM:
      return "the file is damaged: a checksum does not match";
    case SLOD_BAD_TABLE:
      return "the table of chunks is not legal";
    case SLOD_BAD_RECORD:
      return "a record refers to something that is not there, or holds a value that is not legal";
    case SLOD_BAD_STREAM:
      return "a stream does not decode to legal vertices or triangles";
    case SLOD_LEVEL_ABSENT:
      return "the level is not in the part of the file that was opened";
    case SLOD_NO_CODEC:
      return "the stream is compressed and no decoder was given";
    case SLOD_BUFFER_TOO_SMALL:
      return "the buffer is too small";
    case SLOD_BAD_ARGUMENT:
      return "an argument is null or out of range";
  }
  return "an unknown status";
}

uint64_t slod_checksum(const void* bytes, size_t size) {
  const uint8_t* at = static_cast<const uint8_t*>(bytes);
  const uint8_t* const end = at + size;
  uint64_t hash = kPrime[4];
  if (size >= 32) {
    uint64_t lane[4] = {kPrime[0] + kPrime[1], kPrime[1], 0, 0 - kPrime[0]};
    for (; end - at >= 32; at += 32) {
      for (int i = 0; i < 4; ++i) lane[i] = mix(lane[i], load<uint64_t>(at + 8 * i));
    }
    hash = rotate(lane[0], 1) + rotate(lane[1], 7) + rotate(lane[2], 12) + rotate(lane[3], 18);
    for (const uint64_t l : lane) hash = (hash ^ mix(0, l)) * kPrime[0] + kPrime[3];
  }
  hash += size;
  for (; end - at >= 8; at += 8) hash = rotate(hash ^ mix(0, load<uint64_t>(at)), 27) * kPrime[0] + kPrime[3];
  for (; end - at >= 4; at += 4) {
    hash = rotate(hash ^ load<uint32_t>(at) * kPrime[0], 23) * kPrime[1] + kPrime[2];
  }
  for (; at < end; ++at) hash = rotate(hash ^ *at * kPrime[4], 11) * kPrime[0];
  hash = (hash ^ hash >> 33) * kPrime[1];
  hash = (hash ^ hash >> 29) * kPrime[2];
  return hash ^ hash >> 32;
}

slod_status slod_open_prefix(const void* bytes, size_t size, slod_file* file) {
  if (!file) return SLOD_BAD_ARGUMENT;
  *file = {};
  if (size == 0) return SLOD_TRUNCATED;
  if (!bytes) return SLOD_BAD_ARGUMENT;
  slod_status status = open_head(static_cast<const uint8_t*>(bytes), size, *file);
  if (status == SLOD_OK) status = open_levels(size, *file);
  if (status != SLOD_OK) *file = {};
  return status;
}

slod_status slod_open(const void* bytes, size_t size, slod_file* file) {
  const slod_status status = slod_open_prefix(bytes, size, file);
  if (status != SLOD_OK || file->file_bytes == size) return status;
  *file = {};
  return SLOD_TRUNCATED;
}

uint32_t slod_prefix_bytes(const slod_file* file, uint32_t level) {
  const slod_level l = slod_get_level(file, level);
  if (l.chunk_count == 0) return 0;
  const slod_chunk last = slod_get_chunk(file, l.first_chunk + l.chunk_count - 1);
  return uint32_t(aligned(uint64_t(last.offset) + last.bytes));
}

uint32_t slod_count(const slod_file* file, slod_kind kind) {
  return uint32_t(kind) < SLOD_SHARED_KINDS ? file->shared[kind].count : 0;
}

slod_chunk slod_get_chunk(const slod_file* file, uint32_t index) {
  if (index >= file->chunk_count) return {};
  return load<slod_chunk>(file->bytes + sizeof(slod_header), index);
}

slod_node slod_get_node(const slod_file* file, uint32_t index) {
  return record<slod_node>(*file, SLOD_NODES, index);
}

slod_joint slod_get_joint(const slod_file* file, uint32_t index) {
  return record<slod_joint>(*file, SLOD_JOINTS, index);
}

slod_material slod_get_material(const slod_file* file, uint32_t index) {
  return record<slod_material>(*file, SLOD_MATERIALS, index);
}

slod_part slod_get_part(const slod_file* file, uint32_t index) {
  return record<slod_part>(*file, SLOD_PARTS, index);
}

slod_morph slod_get_morph(const slod_file* file, uint32_t index) {
  return record<slod_morph>(*file, SLOD_MORPHS, index);
}

slod_level slod_get_level(const slod_file* file, uint32_t index) {
  return record<slod_level>(*file, SLOD_LEVELS, index);
}

slod_section slod_get_section(const slod_file* file, uint32_t index) {
  return record<slod_section>(*file, SLOD_SECTIONS, index);
}

slod_section_joint slod_get_section_joint(const slod_file* file, uint32_t index) {
  return record<slod_section_joint>(*file, SLOD_SECTION_JOINTS, index);
}

const char* slod_name(const slod_file* file, uint32_t name) {
  if (name >= slod_count(file, SLOD_NAMES)) return "";
  return reinterpret_cast<const char*>(file->bytes + file->shared[SLOD_NAMES].offset + name);
}

uint32_t slod_find(const slod_file* file, uint32_t level, slod_kind kind, uint32_t set) {
  const slod_level l = slod_get_level(file, level);
  for (uint32_t i = 0; i < l.chunk_count; ++i) {
    const slod_chunk c = slod_get_chunk(file, l.first_chunk + i);
    if (c.kind == uint32_t(kind) && c.set == set) return l.first_chunk + i;
  }
  return SLOD_NONE;
}

slod_status slod_decode(const slod_file* file, uint32_t chunk, const slod_codecs* codecs, void* out,
                        size_t out_bytes) {
  const slod_chunk c = slod_get_chunk(file, chunk);
  if (!out || chunk >= file->chunk_count || !known_stream(c.kind)) return SLOD_BAD_ARGUMENT;
  if (c.level < file->first_level) return SLOD_LEVEL_ABSENT;
  if (out_bytes < uint64_t(c.count) * c.stride) return SLOD_BUFFER_TOO_SMALL;

  const uint8_t* const stored = file->bytes + c.offset;
  if (c.codec == SLOD_RAW) {
    memcpy(out, stored, c.bytes);
  } else {
    const auto decode = !codecs                          ? nullptr
                        : c.codec == SLOD_MESHOPT_VERTEX ? codecs->decode_vertices
                                                         : codecs->decode_indices;
    if (!decode) return SLOD_NO_CODEC;
    if (decode(out, c.count, c.stride, stored, c.bytes) != 0) return SLOD_BAD_STREAM;
  }
  return valid_stream(*file, c, out) ? SLOD_OK : SLOD_BAD_STREAM;
}

uint32_t slod_components(const slod_chunk* chunk) {
  switch (chunk->kind) {
    case SLOD_POSITION:
    case SLOD_NORMAL:
      return 3;
    case SLOD_TANGENT:
    case SLOD_COLOUR:
      return 4;
    case SLOD_UV:
      return 2;
    default:
      return 0;
  }
}

void slod_unpack(const slod_chunk* chunk, const void* decoded, float* values) {
  const uint32_t components = slod_components(chunk);
  const uint8_t* item = static_cast<const uint8_t*>(decoded);
  for (uint32_t i = 0; i < chunk->count; ++i, item += chunk->stride, values += components) {
    if (chunk->kind == SLOD_NORMAL) {
      unfold_octahedron(float(load<int16_t>(item)) / 32767, float(load<int16_t>(item + 2)) / 32767, values);
    } else if (chunk->kind == SLOD_TANGENT) {
      unfold_octahedron(float(load<int8_t>(item)) / 127, float(load<int8_t>(item + 1)) / 127, values);
      values[3] = load<int8_t>(item + 2) < 0 ? -1.0f : 1.0f;
    } else {
      for (uint32_t k = 0; k < components; ++k) {
        const uint32_t integer = chunk->kind == SLOD_COLOUR ? item[k] : load<uint16_t>(item, k);
        values[k] = chunk->base[k] + chunk->step[k] * float(integer);
      }
    }
  }
}

void slod_add_morphs(const slod_file* file, const slod_chunk* offsets_chunk, const uint32_t* ranges,
                     const slod_morph_offset* offsets, const float* weights, float* positions,
                     float* normals) {
  for (uint32_t m = 0; m < slod_count(file, SLOD_MORPHS); ++m) {
    if (weights[m] == 0) continue;
    for (uint32_t i = ranges[m]; i < ranges[m + 1]; ++i) {
      const slod_morph_offset& o = offsets[i];
      for (int k = 0; k < 3; ++k) {
        positions[3 * size_t(o.vertex) + k] += weights[m] * offsets_chunk->step[k] * float(o.position[k]);
        if (normals) {
          normals[3 * size_t(o.vertex) + k] += weights[m] * offsets_chunk->step[3] * float(o.normal[k]);
        }
      }
    }
  }
}

void slod_rest_locals(const slod_file* file, float* locals) {
  for (uint32_t i = 0; i < slod_count(file, SLOD_NODES); ++i) {
    rest_local(*file, slod_get_node(file, i), locals + 12 * size_t(i));
  }
}

void slod_globals(const slod_file* file, const float* locals, float* globals) {
  for (uint32_t i = 0; i < slod_count(file, SLOD_NODES); ++i) {
    const int32_t parent = slod_get_node(file, i).parent;
    float local[12];
    memcpy(local, locals + 12 * size_t(i), sizeof local);
    if (parent < 0) {
      memcpy(globals + 12 * size_t(i), local, sizeof local);
    } else {
      compose(globals + 12 * size_t(parent), local, globals + 12 * size_t(i));
    }
  }
}

void slod_needed(const slod_file* file, uint32_t level, uint8_t* joints, uint8_t* nodes) {
  const slod_level l = slod_get_level(file, level);
  for (uint32_t i = 0; i < l.section_count; ++i) {
    const slod_section s = slod_get_section(file, l.first_section + i);
    for (uint32_t j = 0; j < s.joint_count; ++j) {
      const uint32_t joint = slod_get_section_joint(file, s.first_joint + j).joint;
      joints[joint] = nodes[slod_get_joint(file, joint).node] = 1;
    }
  }
  // Parents stand before their children.
  for (uint32_t n = slod_count(file, SLOD_NODES); n-- > 0;) {
    const int32_t parent = slod_get_node(file, n).parent;
    if (nodes[n] && parent >= 0) nodes[parent] = 1;
  }
}

void slod_palette(const slod_file* file, const float* globals, float* palette) {
  for (uint32_t i = 0; i < slod_count(file, SLOD_JOINTS); ++i) {
    const slod_joint joint = slod_get_joint(file, i);
    compose(globals + 12 * size_t(joint.node), joint.inverse_bind, palette + 12 * size_t(i));
  }
}

void slod_skin(const slod_file* file, uint32_t level, const uint8_t* joints, const uint8_t* weights,
               const float* palette, float* positions, float* normals) {
  const slod_level l = slod_get_level(file, level);
  for (uint32_t i = 0; i < l.section_count; ++i) {
    const slod_section s = slod_get_section(file, l.first_section + i);
    uint32_t section_joint[SLOD_MAX_SECTION_JOINTS];
    for (uint32_t j = 0; j < s.joint_count; ++j) {
      section_joint[j] = slod_get_section_joint(file, s.first_joint + j).joint;
    }
    for (size_t v = s.first_vertex; v < size_t(s.first_vertex) + s.vertex_count; ++v) {
      float blend[12] = {};
      for (size_t k = v * l.influence_slots; k < (v + 1) * l.influence_slots && weights[k] > 0; ++k) {
        const float* m = palette + 12 * size_t(section_joint[joints[k]]);
        for (int e = 0; e < 12; ++e) blend[e] += float(weights[k]) / 255 * m[e];
      }
      const float x[3] = {positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]};
      transform(blend, x, positions + 3 * v);
      if (normals) turn_normal(blend, normals + 3 * v);
    }
  }
}

void slod_posed_bounds(const slod_file* file, uint32_t level, const float* globals, float box_min[3],
                       float box_max[3]) {
  PosedBox box = {{}, {}, false};
  const slod_chunk groups = chunk_in_place(*file, level, SLOD_GROUP);
  for (uint32_t i = 0; i < groups.count; ++i) add_group(*file, group_at(*file, groups, i), globals, box);
  const slod_level l = slod_get_level(file, level);
  for (uint32_t i = 0; i < l.section_count && groups.count == 0; ++i) {
    const slod_section s = slod_get_section(file, l.first_section + i);
    for (uint32_t j = 0; j < s.joint_count; ++j) {
      const slod_section_joint b = slod_get_section_joint(file, s.first_joint + j);
      const float* m = globals + 12 * size_t(slod_get_joint(file, b.joint).node);
      for (int r = 0; r < 3; ++r) {
        const Extent e = extent(m + 4 * r, b.box_min, b.box_max);
        add(box, r, e.low - kRounding * e.size, e.high + kRounding * e.size);
      }
      box.any = true;
    }
  }
  if (!box.any) return;
  memcpy(box_min, box.low, sizeof box.low);
  memcpy(box_max, box.high, sizeof box.high);
}

int slod_clip_bounds(const slod_file* file, uint32_t level, float box_min[3], float box_max[3]) {
  const slod_chunk chunk = chunk_in_place(*file, level, SLOD_CLIP_BOX);
  if (chunk.count == 0) return 0;
  const auto box = load<slod_clip_box>(file->bytes + chunk.offset);
  memcpy(box_min, box.box_min, sizeof box.box_min);
  memcpy(box_max, box.box_max, sizeof box.box_max);
  return 1;
}

float slod_pixel_error(const slod_file* file, uint32_t level, const slod_view* view) {
  const slod_level l = slod_get_level(file, level);
  const float error = l.unseen_clip.max > l.examples.max ? l.unseen_clip.max : l.examples.max;
  if (error == 0) return 0;
  const float distance = view->distance > 1e-6f ? view->distance : 1e-6f;
  return error * view->model_scale * view->projection_scale * view->viewport_height / (2 * distance);
}

uint32_t slod_select_level(const slod_file* file, const slod_view* view, uint32_t current) {
  if (file->first_level >= file->level_count) return SLOD_NONE;
  const uint32_t fitting = coarsest_within(*file, *view, view->pixel_tolerance);
  if (current < file->first_level || current >= file->level_count) return fitting;
  const float pixels = slod_pixel_error(file, current, view);
  if (!(pixels <= view->pixel_tolerance * (1 + view->hysteresis))) return fitting;
  const uint32_t coarser = coarsest_within(*file, *view, view->pixel_tolerance * (1 - view->hysteresis));
  return coarser > current ? coarser : current;
}

}  // extern "C"
