#include "firmware/board/sample_ring.hpp"

#include "firmware/board/test/check.hpp"
#include "firmware/board/test/rig.hpp"

namespace roadbalance::board::test {
namespace {

SampleRing& ring_with(const SampleRing::Setup& setup) {
  static SampleRing ring;
  ring.start(setup);
  return ring;
}

std::uint32_t word_in(const StoredScan& scan, std::size_t channel) {
  const std::uint8_t* bytes = &scan.bytes[2 + 3 * channel];
  return bytes[0] | std::uint32_t{bytes[1]} << 8 | std::uint32_t{bytes[2]} << 16;
}

std::uint32_t overload_in(const StoredScan& scan) {
  return scan.bytes[0] | std::uint32_t{scan.bytes[1]} << 8;
}

}  // namespace

BOARD_TEST(ring_marks_words_at_their_limit_and_what_the_hardware_says) {
  SampleRing& ring = ring_with({.ticks_per_scan = 100, .loop_back = true});
  ScanWords words{};
  words[0] = 0x7FFFFF;
  words[1] = 0x7FFFFE;
  words[2] = 0x800000;
  words[3] = 0x800001;
  words[15] = 0xFF7FFFFF;  // what a converter sends above its 24 bits does not count
  CHECK(ring.add(words, 1u << 9, 100));
  CHECK(ring.add(ScanWords{}, 0, 200));
  CHECK_EQUAL(overload_in(ring.queue()[0]), 1u << 0 | 1u << 2 | 1u << 9 | 1u << 15);
  CHECK_EQUAL(overload_in(ring.queue()[1]), 0);
  CHECK_EQUAL(ring.overloads(), 1);
  for (std::size_t k = 0; k < kStreamChannels; ++k)
    CHECK_EQUAL(word_in(ring.queue()[0], k), words[k] & 0xFFFFFF);
}

BOARD_TEST(ring_has_no_loop_back_without_references) {
  SampleRing& ring = ring_with({.ticks_per_scan = 100});
  ScanWords words;
  words.fill(0x7FFFFF);
  CHECK(ring.add(words, 0, 100));
  CHECK_EQUAL(overload_in(ring.queue()[0]), 0xFFF);
  for (std::size_t k = 0; k < kStreamChannels; ++k)
    CHECK_EQUAL(word_in(ring.queue()[0], k), k < kInputChannels ? 0x7FFFFF : 0);
}

BOARD_TEST(ring_counts_conversions_by_their_time) {
  SampleRing& ring = ring_with({.ticks_per_scan = 100});
  // 1101 and 1240 are within half a period of the one before; 1505 is three periods behind 1195.
  for (const std::uint64_t ticks : {1000, 1100, 1101, 1195, 1240, 1505})
    CHECK(ring.add(ScanWords{}, 0, ticks));
  constexpr std::array<std::uint64_t, 4> kIndices = {0, 1, 2, 5};
  REQUIRE(ring.queue().size() == kIndices.size());
  for (std::size_t k = 0; k < kIndices.size(); ++k) CHECK_EQUAL(ring.queue()[k].index, kIndices[k]);
  CHECK_EQUAL(ring.glitches(), 2);
  CHECK_EQUAL(ring.missed(), 2);
}

BOARD_TEST(ring_that_is_full_loses_scans_by_their_index) {
  SampleRing& ring = ring_with({.ticks_per_scan = 100, .pattern = Pattern::kCounter});
  std::uint64_t ticks = 0;
  for (std::size_t k = 0; k < SampleRing::kScans + 7; ++k) CHECK(ring.add(ScanWords{}, 0, ticks += 100));
  CHECK_EQUAL(ring.lost(), 7);
  ring.queue().drop(SampleRing::kScans);
  CHECK(ring.add(ScanWords{}, 0, ticks += 100));
  REQUIRE(ring.queue().size() == 1);
  constexpr std::uint64_t kIndex = SampleRing::kScans + 7;
  CHECK_EQUAL(ring.queue()[0].index, kIndex);
  CHECK_EQUAL(word_in(ring.queue()[0], 3), kIndex * 16 + 3);
  CHECK_EQUAL(ring.missed(), 0);
}

BOARD_TEST(ring_refuses_to_count_over_too_long_a_hole) {
  SampleRing& ring = ring_with({.ticks_per_scan = 100});
  CHECK(ring.add(ScanWords{}, 0, 100));
  CHECK(ring.add(ScanWords{}, 0, 100 + 2500 * 100));
  CHECK_EQUAL(ring.queue()[1].index, 2500);
  CHECK(!ring.add(ScanWords{}, 0, 100 + 5001 * 100));
  CHECK_EQUAL(ring.queue().size(), 2);
}

}  // namespace roadbalance::board::test
