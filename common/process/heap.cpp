#include "common/process/heap.hpp"

#include <malloc.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

namespace roadbalance {
namespace {

constexpr int kLargest = 32 << 20;        // of M_MMAP_THRESHOLD: what glibc takes on 64 bits
constexpr std::size_t kPiece = 64 << 10;  // pieces that lie side by side are one again when they are freed
constexpr std::size_t kPage = 4096;

}  // namespace

void keep_heap() {
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_THRESHOLD, kLargest);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

void reserve_heap(std::size_t bytes) {
  std::vector<std::unique_ptr<volatile char[]>> pieces((bytes + kPiece - 1) / kPiece);
  for (auto& piece : pieces) {
    piece.reset(new volatile char[kPiece]);
    for (std::size_t at = 0; at < kPiece; at += kPage) piece[at] = 0;
  }
}

}  // namespace roadbalance
