// SPDX-License-Identifier: MIT
#include "pipeline/large_pages.h"

#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace skinlod {
namespace {

constexpr size_t kPage = size_t(2) << 20;
bool is_large(size_t bytes) { return bytes >= 2 * kPage; }

}  // namespace

void* take_pages(size_t bytes) {
  if (!is_large(bytes)) return ::operator new(bytes);
  void* const pages = ::operator new(bytes, std::align_val_t(kPage));
#ifdef MADV_HUGEPAGE
  madvise(pages, bytes, MADV_HUGEPAGE);  // where it is refused the pages stay small
#endif
  return pages;
}

void give_back_pages(void* pages, size_t bytes) {
  if (is_large(bytes)) {
    ::operator delete(pages, std::align_val_t(kPage));
  } else {
    ::operator delete(pages);
  }
}

}  // namespace skinlod
