// SPDX-License-Identifier: MIT
#include "tests/fuzz/checksums.h"
#include "tests/fuzz/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> bytes(data, data + size);
  skinlod::fuzz::read_as_slod(bytes);
  skinlod::fuzz::repair_checksums(bytes);
  skinlod::fuzz::read_as_slod(bytes);
  return 0;
}
