#include "common/record/record_reader.hpp"
#include "common/record/record_writer.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <random>

#include "common/record/segment.hpp"
#include "common/types/crc32c.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

class Record : public ::testing::Test {
 protected:
  Record()
      : folder(fs::temp_directory_path() /
               ("rb-record-" + std::to_string(::getpid()) + "-" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder);
  }
  ~Record() override { fs::remove_all(folder); }

  // Ends with its CRC, as everything that we record.
  static Bytes payload(int number) {
    std::mt19937 random(static_cast<unsigned>(number));
    Bytes bytes(20 + random() % 60);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const std::uint32_t crc = crc32c({bytes.data(), bytes.size() - 4});
    for (std::size_t k = 0; k < 4; ++k)
      bytes[bytes.size() - 4 + k] = static_cast<std::uint8_t>(crc >> (24 - 8 * k));
    return bytes;
  }

  static void append(RecordWriter& writer, int first, int count) {
    for (int k = first; k < first + count; ++k) writer.append("CHANNEL", payload(k), 1000 * k);
  }

  static std::vector<Bytes> read_all(RecordReader& reader) {
    std::vector<Bytes> events;
    while (const auto event = reader.next()) {
      if (event->channel == kCommitChannel) continue;
      EXPECT_EQ(event->channel, "CHANNEL");
      events.emplace_back(event->data.begin(), event->data.end());
    }
    return events;
  }

  static std::vector<Bytes> payloads(int first, int count) {
    std::vector<Bytes> all;
    for (int k = first; k < first + count; ++k) all.push_back(payload(k));
    return all;
  }

  static Bytes content(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // In place: some file systems sync a file that is truncated to nothing and written again.
  static void write(const fs::path& path, std::span<const std::uint8_t> bytes) {
    std::fstream(path, std::ios::binary | std::ios::in | std::ios::out)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    fs::resize_file(path, bytes.size());
  }

  // The events that close() puts behind all that was appended.
  static std::size_t last_commit_bytes() {
    return 28 + std::string_view(kCommitChannel).size() + encode(Commit()).size();
  }

  const fs::path folder;
};

TEST_F(Record, GivesBackEveryEventOfEverySegmentInOrder) {
  RecordWriter writer({.folder = folder, .segment_bytes = 1000});
  append(writer, 0, 100);
  writer.close();
  EXPECT_GT(segment_numbers(folder).size(), 5u);
  RecordReader reader(folder);
  EXPECT_EQ(read_all(reader), payloads(0, 100));
  EXPECT_TRUE(reader.damage().empty());
}

TEST_F(Record, BeginsEverySegmentWithThePreamble) {
  RecordWriter writer({.folder = folder, .segment_bytes = 1000});
  std::size_t made = 0;
  writer.set_preamble([&made](const RecordState&) {
    ++made;
    return RecordEvents{{"CHANNEL", payload(4711)}};
  });
  append(writer, 0, 100);
  writer.close();
  EXPECT_EQ(made, segment_numbers(folder).size()) << "of many nodes it is long: not with every block";
  for (const int number : segment_numbers(folder)) {
    SegmentReader segment(segment_path(folder, number));
    std::vector<RecordReader::Damage> damage;
    const auto first = segment.next(true, damage);
    ASSERT_TRUE(first);
    EXPECT_EQ(Bytes(first->data.begin(), first->data.end()), payload(4711));
  }
}

// The bytes of an LCM event log, written down from LCM's eventlog.c and not from our code.
TEST_F(Record, IsAnLcmEventLog) {
  RecordWriter writer({.folder = folder});
  const Bytes data{1, 2, 3};
  writer.append("AB", data, 0x0102030405060708);
  writer.close();
  const Bytes expected{0xED, 0xA1, 0xDA, 0x01, 0, 0, 0, 0, 0, 0, 0, 0,   1,   2, 3, 4, 5,
                       6,    7,    8,    0,    0, 0, 2, 0, 0, 0, 3, 'A', 'B', 1, 2, 3};
  Bytes written = content(segment_path(folder, 1));
  ASSERT_EQ(written.size(), expected.size() + last_commit_bytes());
  written.resize(expected.size());
  EXPECT_EQ(written, expected);
}

TEST_F(Record, AnyPrefixGivesExactlyItsCompleteEvents) {
  constexpr int kEvents = 15;
  std::vector<std::size_t> ends;
  {
    RecordWriter writer({.folder = folder});
    std::size_t end = 0;
    for (int k = 0; k < kEvents; ++k) {
      append(writer, k, 1);
      ends.push_back(end += 28 + 7 + payload(k).size());
    }
    writer.close();
    ends.push_back(end + last_commit_bytes());
  }
  const Bytes whole = content(segment_path(folder, 1));
  ASSERT_EQ(whole.size(), ends.back());
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    write(segment_path(folder, 1), {whole.data(), size});
    RecordReader reader(folder);
    reader.finish();
    const auto complete = static_cast<int>(std::upper_bound(ends.begin(), ends.end(), size) - ends.begin());
    ASSERT_EQ(read_all(reader), payloads(0, std::min(complete, kEvents))) << "cut at " << size;
    const std::size_t torn = size - (complete > 0 ? ends[static_cast<std::size_t>(complete) - 1] : 0);
    ASSERT_EQ(reader.damage().size(), torn > 0 ? 1u : 0u);
    if (torn > 0) {
      ASSERT_EQ(reader.damage()[0].bytes, torn);
    }
  }
}

// Only the event that was hit is lost or altered, and every event lost is listed as damage.
TEST_F(Record, AnyDamagedByteCostsOnlyTheEventItIsIn) {
  constexpr int kEvents = 8;
  {
    RecordWriter writer({.folder = folder});
    append(writer, 0, kEvents);
    writer.close();
  }
  const Bytes whole = content(segment_path(folder, 1));
  for (std::size_t at = 0; at < whole.size(); ++at) {
    Bytes damaged = whole;
    damaged[at] ^= 0x55;
    write(segment_path(folder, 1), damaged);
    RecordReader reader(folder);
    reader.finish();
    std::size_t good = 0;
    std::size_t given = 0;
    while (const auto event = reader.next()) {
      ++given;
      const Bytes data(event->data.begin(), event->data.end());
      for (int k = 0; k < kEvents; ++k) good += data == payload(k) && event->channel == "CHANNEL" ? 1 : 0;
    }
    ASSERT_GE(good, kEvents - 1u) << "byte " << at;
    ASSERT_LE(given, kEvents + 1u) << "byte " << at;
    ASSERT_EQ(given == kEvents + 1, reader.damage().empty()) << "byte " << at;
  }
}

TEST_F(Record, AFollowingReaderSeesEverythingAlsoAcrossSegments) {
  RecordWriter writer({.folder = folder, .segment_bytes = 700});
  append(writer, 0, 1);
  writer.sync();
  RecordReader reader(folder);
  std::vector<Bytes> seen = read_all(reader);
  for (int k = 1; k < 200; ++k) {
    append(writer, k, 1);
    if (k % 7 == 0) writer.sync();
    if (k % 3 == 0)
      for (auto& event : read_all(reader)) seen.push_back(std::move(event));
  }
  writer.close();
  for (auto& event : read_all(reader)) seen.push_back(std::move(event));
  EXPECT_EQ(seen, payloads(0, 200));
  EXPECT_TRUE(reader.damage().empty());
}

TEST_F(Record, AFollowingReaderWaitsForTheRestOfAnEvent) {
  {
    RecordWriter writer({.folder = folder});
    append(writer, 0, 2);
    writer.close();
  }
  const Bytes whole = content(segment_path(folder, 1));
  write(segment_path(folder, 1), {whole.data(), whole.size() - last_commit_bytes() - 9});
  RecordReader reader(folder);
  EXPECT_EQ(read_all(reader), payloads(0, 1));
  EXPECT_FALSE(reader.next());
  write(segment_path(folder, 1), whole);
  EXPECT_EQ(read_all(reader), payloads(1, 1));
  EXPECT_TRUE(reader.damage().empty());
}

TEST_F(Record, AWriterThatContinuesCutsTheTornTailAndKeepsItBeside) {
  {
    RecordWriter writer({.folder = folder});
    append(writer, 0, 10);
    writer.close();
  }
  Bytes whole = content(segment_path(folder, 1));
  whole.resize(whole.size() - last_commit_bytes());
  write(segment_path(folder, 1), {whole.data(), whole.size() - 5});
  {
    RecordWriter writer({.folder = folder});
    ASSERT_TRUE(writer.cut_tail());
    EXPECT_EQ(writer.cut_tail()->cut, 28 + 7 + payload(9).size() - 5);
    const Bytes tail = content(folder / "seg-000001.tail");
    EXPECT_TRUE(
        std::equal(tail.begin(), tail.end(), whole.end() - 5 - static_cast<std::ptrdiff_t>(tail.size())));
    EXPECT_EQ(tail.size(), writer.cut_tail()->cut);
    append(writer, 9, 5);
    writer.close();
  }
  RecordReader reader(folder);
  reader.finish();
  EXPECT_EQ(read_all(reader), payloads(0, 14));
  EXPECT_TRUE(reader.damage().empty());
}

TEST_F(Record, WhatIsSyncedIsThereThoughTheWriterWasNeverClosed) {
  {
    RecordWriter writer({.folder = folder});
    append(writer, 0, 10);
    writer.sync();
    append(writer, 10, 1);
  }
  RecordReader reader(folder);
  const auto seen = read_all(reader);
  ASSERT_GE(seen.size(), 10u);
  EXPECT_EQ(std::vector<Bytes>(seen.begin(), seen.begin() + 10), payloads(0, 10));
}

TEST_F(Record, TheFileIsNeverLongerThanItsEvents) {
  RecordWriter writer({.folder = folder});
  append(writer, 0, 10);
  writer.sync();
  std::uintmax_t bytes = 0;
  for (const Bytes& data : payloads(0, 10)) bytes += 28 + 7 + data.size();  // header, channel, payload
  EXPECT_EQ(fs::file_size(segment_path(folder, 1)), bytes);
}

TEST_F(Record, ASegmentWithoutAnyEventIsTakenAwayAndItsNumberUsedAgain) {
  fs::create_directories(folder);
  std::ofstream(segment_path(folder, 1), std::ios::binary);
  RecordWriter writer({.folder = folder});
  append(writer, 0, 3);
  writer.close();
  EXPECT_EQ(segment_numbers(folder), std::vector<int>{1});
  RecordReader reader(folder);
  EXPECT_EQ(read_all(reader), payloads(0, 3));
}

TEST_F(Record, ASecondWriterIsRefused) {
  RecordWriter writer({.folder = folder});
  EXPECT_THROW(RecordWriter({.folder = folder}), std::runtime_error);
}

TEST_F(Record, AFolderWithoutSegmentsIsNoRecording) {
  EXPECT_THROW(RecordReader{folder}, std::system_error);
  fs::create_directories(folder);
  EXPECT_THROW(RecordReader{folder}, std::system_error);
}

}  // namespace
}  // namespace roadbalance
