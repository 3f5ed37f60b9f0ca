#include "common/record/recorded_clocks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <random>
#include <system_error>

#include "common/bus/clock_messages.hpp"
#include "common/bus/codec.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/record_writer.hpp"
#include "common/record/segment.hpp"
#include "common/record/test/simulated_disk.hpp"

namespace roadbalance {
namespace {

using test::DiskCall;
using test::SimulatedDisk;

constexpr NodeEpoch kOne{1, 77}, kOther{2, 78};
constexpr std::int64_t kBlock_ns = 10'000'000;
constexpr std::int64_t kBlocksPerFit = 100;
constexpr std::int64_t kNotedUtc_us = 1'790'000'000'000'000;  // at the host's instant 0

// The truth: node 1 gains 20 us a second, node 2 loses 30.
std::int64_t node_ns(const NodeEpoch& of, std::int64_t host_ns) {
  const double drift = of == kOne ? 20e-6 : -30e-6;
  return 5'000'000'000 * of.first + host_ns + std::llround(drift * static_cast<double>(host_ns));
}

ClockFit fit_at(const NodeEpoch& of, std::int64_t host_ns) {
  return {.node = of.first,
          .epoch = of.second,
          .number = 1 + host_ns / (kBlocksPerFit * kBlock_ns),
          .state = ClockState::kLocked,
          .host_ns = host_ns,
          .node_ns = node_ns(of, host_ns),
          .drift = of == kOne ? 20e-6 : -30e-6};
}

class RecordedClocksTest : public ::testing::Test {
 protected:
  void begin() {
    writer.emplace(RecordWriter::Options{.folder = "/record", .segment_bytes = 64 << 10}, disk);
  }
  void append(const ClockFit& fit) { writer->append(clock_fit_channel(fit.node), encode(fit), 0); }
  void note(std::int64_t host_ns) {
    writer->append(kNoteChannel,
                   encode(Note{.time_us = kNotedUtc_us + host_ns / 1000,
                               .host_ns = host_ns,
                               .incarnation = 3,
                               .kind = NoteKind::kDevice,
                               .text = "whatever it tells, it has the pair"}),
                   0);
  }
  void append_scans(const NodeEpoch& of, std::int64_t sequence) {
    ScanBlock block{.header = {.node = of.first,
                               .epoch = of.second,
                               .sequence = sequence,
                               .first_scan = 20 * (sequence - 1),
                               .scans = 20,
                               .time_ns = node_ns(of, sequence * kBlock_ns)},
                    .period_ps = 500'000'000};
    SealedBlock sealed;
    seal(block, sealed);
    writer->append(sealed, 0);
  }
  // A fit of each node and a note every second, as a recorder keeps them; from block to block in 10 ms.
  void drive(std::int64_t first, std::int64_t last) {
    for (std::int64_t k = first; k <= last; ++k) {
      if (k % kBlocksPerFit == 0) {
        append(fit_at(kOne, k * kBlock_ns));
        append(fit_at(kOther, k * kBlock_ns));
        note(k * kBlock_ns);
      }
      append_scans(kOne, k);
      append_scans(kOther, k);
    }
  }
  // The events of one segment alone: nothing else of the record is there.
  std::vector<std::pair<std::string, std::vector<std::uint8_t>>> alone(int number) {
    SimulatedDisk elsewhere;
    EXPECT_EQ(elsewhere.mkdir("/alone", 0755), 0);
    elsewhere.put(segment_path("/alone", number), disk.content(segment_path("/record", number)));
    RecordReader reader("/alone", elsewhere);
    reader.finish();
    std::vector<std::pair<std::string, std::vector<std::uint8_t>>> events;
    while (const auto event = reader.next())
      events.emplace_back(event->channel, std::vector<std::uint8_t>(event->data.begin(), event->data.end()));
    return events;
  }
  std::vector<ClockFit> fits_of(int number) {
    std::vector<ClockFit> fits;
    for (const auto& [channel, data] : alone(number))
      if (const auto fit = decode_clock_fit(data)) fits.push_back(*fit);
    return fits;
  }

  SimulatedDisk disk;
  std::optional<RecordWriter> writer;
};

TEST_F(RecordedClocksTest, EachSegmentAlonePlacesEachOfItsBlocksOnHostTimeAndUtc) {
  begin();
  drive(kBlocksPerFit, 5 * kBlocksPerFit);
  writer->close();
  const int segments = writer->segment();
  ASSERT_GE(segments, 10) << "most hold no fit of their own";
  std::int64_t blocks = 0;
  for (int number = 1; number <= segments; ++number) {
    RecordedClocks clocks;
    for (const auto& [channel, data] : alone(number)) {
      SealedBlock block;
      if (accept(data, block) != Refusal::kNone) {
        static_cast<void>(clocks.take(channel, data));
        continue;
      }
      const auto host_ns = clocks.host_ns({block.header.node, block.header.epoch}, block.header.time_ns);
      ASSERT_TRUE(host_ns) << "segment " << number;
      // Both instants of the line are whole nanoseconds.
      EXPECT_NEAR(static_cast<double>(*host_ns - block.header.sequence * kBlock_ns), 0.0, 2.0);
      const auto utc_us = clocks.utc_us(*host_ns);
      ASSERT_TRUE(utc_us);
      EXPECT_NEAR(static_cast<double>(*utc_us - kNotedUtc_us - block.header.sequence * kBlock_ns / 1000), 0.0,
                  1.0);
      ++blocks;
    }
  }
  EXPECT_EQ(blocks, 2 * (4 * kBlocksPerFit + 1));
}

// The host's clock begins anew; a fit to the one before would be off by both uptimes.
TEST(RecordedClocks, ForgetsFitsWhenTheHostIsBootedAnew) {
  RecordedClocks clocks;
  std::int64_t incarnation = 3;  // of the recorder
  const auto take_pair = [&](std::int64_t host_ns, std::int64_t time_us) {
    const Note pair{.time_us = time_us,
                    .host_ns = host_ns,
                    .incarnation = incarnation,
                    .kind = NoteKind::kClock,
                    .text = {}};
    static_cast<void>(clocks.take(kNoteChannel, encode(pair)));
  };
  const auto take_fit = [&](std::int64_t host_ns) {
    static_cast<void>(clocks.take(clock_fit_channel(kOne.first), encode(fit_at(kOne, host_ns))));
  };
  constexpr std::int64_t kBefore_ns = 5'000'000'000'000, kAfter_ns = 20'000'000'000;
  take_pair(kBefore_ns, kNotedUtc_us);
  take_fit(kBefore_ns);
  take_pair(kBefore_ns - 1, kNotedUtc_us - 1);  // a segment repeats one of before
  EXPECT_TRUE(clocks.host_ns(kOne, node_ns(kOne, kBefore_ns)));
  incarnation = 4;
  take_pair(kAfter_ns, kNotedUtc_us + 60'000'000);
  EXPECT_FALSE(clocks.host_ns(kOne, node_ns(kOne, kBefore_ns)));
  take_fit(kAfter_ns);
  EXPECT_TRUE(clocks.host_ns(kOne, node_ns(kOne, kAfter_ns)));
}

// Notes may stand before the pair of clocks that was known before them: the one that gives up a segment
// before the preamble of the next, and those of a folder's tail before what its fallback begins with.
TEST(RecordedClocks, AnOlderPairThatIsRepeatedBehindWallTimeSetBackIsNoHostBootedAnew) {
  RecordedClocks clocks;
  const auto take_note = [&](NoteKind kind, std::int64_t host_ns, std::int64_t time_us) {
    const Note note{.time_us = time_us,
                    .host_ns = host_ns,
                    .incarnation = 3,
                    .kind = kind,
                    .a = 1,
                    .b = 4096,
                    .text = {}};
    ASSERT_TRUE(decode_note(encode(note)));
    static_cast<void>(clocks.take(kNoteChannel, encode(note)));
  };
  constexpr std::int64_t kHour_us = 3'600'000'000;
  take_note(NoteKind::kClock, 100, kNotedUtc_us);
  static_cast<void>(clocks.take(clock_fit_channel(kOne.first), encode(fit_at(kOne, 0))));
  take_note(NoteKind::kSegmentAbandoned, 105, kNotedUtc_us - kHour_us);
  take_note(NoteKind::kClock, 100, kNotedUtc_us);
  EXPECT_TRUE(clocks.host_ns(kOne, node_ns(kOne, 0)));
}

// Each fit is there once for a reader of all of it, however often it is repeated.
TEST_F(RecordedClocksTest, WhoReadsTheWholeRecordIsGivenEachFitOnce) {
  begin();
  drive(kBlocksPerFit, 5 * kBlocksPerFit);
  writer->close();
  RecordReader reader("/record", disk);
  reader.finish();
  RecordedClocks clocks;
  std::int64_t fits = 0, events = 0;
  while (const auto event = reader.next()) {
    events += decode_clock_fit(event->data) ? 1 : 0;
    if (const auto fit = clocks.take(event->channel, event->data)) ++fits;
  }
  EXPECT_EQ(fits, 2 * 5);
  EXPECT_GT(events, fits);
}

// Holes, breaks of the time base, hosts booted anew and recorders without any fit yet, in any order; at any
// instant a segment may begin, and a reader that begins there has the same clocks as one that has read all of
// it.
TEST(RecordedClocks, WhoBeginsWithASegmentKnowsTheClocksFromThenOnAsWhoReadsAll) {
  std::mt19937_64 random(4711);
  const auto below = [&random](std::uint64_t n) { return static_cast<std::int64_t>(random() % n); };
  const auto all_events = [](const RecordedClocks& clocks) {
    return clocks.events([](const NodeEpoch&) { return true; });
  };
  RecordedClocks all, since;
  std::int64_t now_ns = 0, booted_ns = 0, breaks = 0;
  std::size_t longest = 0;
  for (int k = 0; k < 20'000; ++k) {
    now_ns += below(40) == 0 ? (2 + below(90)) * 1'000'000'000 : 1'000'000'000;
    if (below(400) == 0) booted_ns = now_ns;
    if (below(200) == 0) ++breaks;
    ClockFit fit = fit_at(kOne, now_ns);
    fit.host_ns -= booted_ns;
    fit.breaks = breaks;
    if (below(15) == 0) fit.state = ClockState::kAcquire;
    if (below(300) == 0) fit.node_ns += 1'000'000'000;
    for (RecordedClocks* clocks : {&all, &since})
      ASSERT_EQ(clocks->take(clock_fit_channel(kOne.first), encode(fit)), fit) << k;
    const RecordEvents events = all_events(all);
    ASSERT_EQ(all_events(since), events) << k;
    for (const auto& [channel, data] : events)
      ASSERT_EQ(all.take(channel, data), std::nullopt) << k << ": one that is only repeated says nothing new";
    ASSERT_EQ(all_events(all), events) << k;
    longest = std::max(longest, events.size());
    if (below(10) != 0) continue;
    since = {};
    for (const auto& [channel, data] : events) static_cast<void>(since.take(channel, data));
  }
  EXPECT_EQ(longest, 4U);
}

TEST_F(RecordedClocksTest, ARecorderThatIsStartedAgainKnowsTheClocksOfTheRecord) {
  begin();
  drive(kBlocksPerFit, kBlocksPerFit + 10);
  writer->sync();
  disk.kill();
  begin();
  append_scans(kOne, kBlocksPerFit + 11);
  writer->close();
  EXPECT_EQ(fits_of(writer->segment()), (std::vector<ClockFit>{fit_at(kOne, kBlocksPerFit * kBlock_ns),
                                                               fit_at(kOther, kBlocksPerFit * kBlock_ns)}));
}

TEST_F(RecordedClocksTest, TheClockOfAnEpochThatHasEndedIsNotRepeated) {
  begin();
  drive(1, kBlocksPerFit);
  SealedBlock end;
  seal(EndBlock{.header = {.node = 1, .epoch = kOne.second, .sequence = kBlocksPerFit + 1}}, end);
  writer->append(end, 0);
  const int segment = writer->segment();
  for (std::int64_t k = kBlocksPerFit + 1; writer->segment() == segment; ++k) append_scans(kOther, k);
  writer->close();
  EXPECT_EQ(fits_of(segment + 1), std::vector<ClockFit>{fit_at(kOther, kBlocksPerFit * kBlock_ns)});
}

// The recorder writes it again, in its place.
TEST_F(RecordedClocksTest, AFitThatTheDiskLostIsNotKnownBeforeItIsWrittenAgain) {
  begin();
  append(fit_at(kOne, 0));
  append_scans(kOne, 1);
  writer->sync();
  append(fit_at(kOne, kBlocksPerFit * kBlock_ns));
  disk.set_fault([](DiskCall call, std::int64_t, const std::string&) {
    return SimulatedDisk::Outcome{.error = call == DiskCall::kSyncData ? EIO : 0};
  });
  EXPECT_THROW(writer->sync(), std::system_error);
  disk.set_fault({});
  writer->abandon({});
  append_scans(kOne, 2);
  append(fit_at(kOne, kBlocksPerFit * kBlock_ns));
  writer->close();
  EXPECT_EQ(fits_of(2), (std::vector<ClockFit>{fit_at(kOne, 0), fit_at(kOne, kBlocksPerFit * kBlock_ns)}));
}

}  // namespace
}  // namespace roadbalance
