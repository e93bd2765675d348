// SPDX-License-Identifier: MIT
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/packed_tube.h"

namespace skinlod {
namespace {

std::vector<std::byte> read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> chars((std::istreambuf_iterator<char>(in)), {});
  std::vector<std::byte> bytes(chars.size());
  std::memcpy(bytes.data(), chars.data(), chars.size());
  return bytes;
}

// Of all integers of all streams.
std::uint64_t decoded_checksum(const slod_file& file) {
  std::vector<std::uint8_t> all;
  for (std::uint32_t c = SLOD_SHARED_KINDS; c < file.chunk_count; ++c) {
    const slod_chunk chunk = slod_get_chunk(&file, c);
    const auto stream = decoded<std::uint8_t>(file, chunk.level, slod_kind(chunk.kind), chunk.set);
    all.insert(all.end(), stream.begin(), stream.end());
  }
  return slod_checksum(all.data(), all.size());
}

}  // namespace

// Files of tests/packed_tube.h, frozen when their version of the format was: every later loader reads them.
TEST_SUITE("golden") {
  TEST_CASE("files of version 1 are read for ever") {
    for (const std::string name : {"v1_tube", "v1_tube_raw"}) {
      CAPTURE(name);
      const auto bytes = read("tests/golden/format/" + name + ".slod");
      REQUIRE(bytes.size() > 0);
      const slod_file file = opened(bytes);
      CHECK(slod_name(&file, 0) == std::string("bending_tube"));
      CHECK(slod_count(&file, SLOD_NODES) == 6);
      CHECK(slod_count(&file, SLOD_JOINTS) == 5);
      CHECK(slod_count(&file, SLOD_MORPHS) == 2);
      REQUIRE(file.level_count == 3);
      CHECK(slod_get_level(&file, 0).triangle_count == 264);
      CHECK(slod_get_level(&file, 1).triangle_count == 96);
      CHECK(slod_get_level(&file, 2).triangle_count == 32);
      CHECK(slod_get_level(&file, 2).max_influences == 2);
      CHECK(slod_get_level(&file, 2).examples.max == 0.04f);
      CHECK(slod_get_section(&file, 0).joint_count == 5);
      CHECK(slod_get_joint(&file, 3).inverse_bind[7] == -3);
      CHECK(decoded_checksum(file) == (name == "v1_tube" ? 0xff67228b09bffbdcu : 0x53fca909dd2703d9u));
    }
  }
}

}  // namespace skinlod
