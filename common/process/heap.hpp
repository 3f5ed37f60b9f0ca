#pragma once

#include <cstddef>

namespace roadbalance {

/// From now on the process has one heap for all its threads, and memory it once had it keeps: for programs
/// that must not find the machine without memory in the middle of a drive.  To be called before threads are.
///
/// Without effect where another allocator has taken malloc's place, as sanitizers do.
void keep_heap();

/// So many bytes are in RAM and the heap's beyond those in use now; later allocations come out of them. After
/// keep_heap().
void reserve_heap(std::size_t bytes);

}  // namespace roadbalance
