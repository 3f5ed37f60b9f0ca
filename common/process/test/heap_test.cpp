#include "common/process/heap.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>
#include <vector>

namespace roadbalance {
namespace {

std::int64_t own_kib() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (std::int64_t kib = 0; word == "RssAnon:" && status >> kib) return kib;
  return -1;
}

/// As a program that waits for its disk: much in small pieces, all at once, in a thread of its own.
void take_and_give_back(std::size_t bytes) {
  std::thread([bytes] {
    std::vector<std::vector<char>> all;
    for (std::size_t taken = 0; taken < bytes; taken += 1500) all.emplace_back(1500, 'x');
  }).join();
}

TEST(Heap, WhatWasReservedIsThereAndNoMoreIsTaken) {
  keep_heap();
  take_and_give_back(1 << 20);  // a thread's stack, and what the first use of all this takes
  const std::int64_t before_kib = own_kib();
  reserve_heap(40 << 20);
  const std::int64_t reserved_kib = own_kib();
  EXPECT_GE(reserved_kib - before_kib, 38 << 10) << "40 MiB, less what was free of the first use";
  for (int time = 0; time < 5; ++time) take_and_give_back(30 << 20);
  EXPECT_LE(own_kib() - reserved_kib, 256);
  EXPECT_GE(own_kib() - reserved_kib, -256) << "kept";
}

}  // namespace
}  // namespace roadbalance
