// SPDX-License-Identifier: MIT
#include "tests/fuzz/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  skinlod::fuzz::read_as_archive({data, size});
  return 0;
}
