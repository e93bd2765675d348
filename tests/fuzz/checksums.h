// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "runtime/slod.h"

namespace skinlod::fuzz {

/// Makes the checksums true again, as far as the lies allow, so that what stands behind them is tried.
inline void repair_checksums(std::vector<std::uint8_t>& bytes) {
  slod_header header;
  if (bytes.size() < sizeof header) return;
  std::memcpy(&header, bytes.data(), sizeof header);
  const auto holds = [&](std::uint64_t offset, std::uint64_t size) { return offset + size <= bytes.size(); };
  const auto chunk = [&](std::uint32_t i) {
    slod_chunk c{};
    const std::uint64_t at = sizeof header + std::uint64_t(i) * sizeof c;
    if (holds(at, sizeof c)) std::memcpy(&c, bytes.data() + at, sizeof c);
    return c;
  };
  const slod_chunk levels = chunk(SLOD_LEVELS);
  for (std::uint32_t i = 0; i < std::min(levels.count, 16u); ++i) {
    slod_level level;
    const std::uint64_t at = levels.offset + std::uint64_t(i) * sizeof level;
    if (!holds(at, sizeof level)) break;
    std::memcpy(&level, bytes.data() + at, sizeof level);
    const slod_chunk last = chunk(level.first_chunk + level.chunk_count - 1);
    const std::uint64_t begin = chunk(level.first_chunk).offset;
    const std::uint64_t end = (std::uint64_t(last.offset) + last.bytes + 15) / 16 * 16;
    if (begin >= end || end > bytes.size()) continue;
    level.checksum = slod_checksum(bytes.data() + begin, size_t(end - begin));
    std::memcpy(bytes.data() + at, &level, sizeof level);
  }
  const size_t covered = offsetof(slod_header, file_bytes);
  if (header.head_bytes < sizeof header || header.head_bytes > bytes.size()) return;
  header.checksum = slod_checksum(bytes.data() + covered, header.head_bytes - covered);
  std::memcpy(bytes.data(), &header, sizeof header);
}

}  // namespace skinlod::fuzz
