#include "common/record/test/numbered_blocks.hpp"

#include <algorithm>
#include <cerrno>
#include <random>
#include <system_error>

#include "common/bus/codec.hpp"
#include "common/record/header_check.hpp"
#include "common/record/log_event.hpp"
#include "common/types/crc32c.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int32_t kNode = 3;
constexpr std::int64_t kEpoch = 0x1234567890ABCDEF;

SealedBlock make_block(std::int64_t sequence) {
  BlockHeader header{.node = kNode, .epoch = kEpoch, .sequence = sequence, .time_ns = sequence * 10'000'000};
  SealedBlock sealed;
  if (sequence % 3 == 0) {
    seal(GapBlock{.header = header, .cause = GapCause::kDeviceOverrun}, sealed);
    return sealed;
  }
  std::mt19937 random(static_cast<unsigned>(sequence));
  ScanBlock block;
  header.scans = kScansPerBlock;
  block.header = header;
  block.period_ps = 500'000'000;
  for (auto& row : block.counts)
    for (auto& value : row) value = static_cast<std::int32_t>(random());
  seal(block, sealed);
  return sealed;
}

[[noreturn]] void throw_away() {
  throw std::system_error(ENODEV, std::generic_category(), "record");
}

}  // namespace

const SealedBlock& numbered_block(std::int64_t sequence) {
  static std::map<std::int64_t, SealedBlock> known;
  const auto [block, is_new] = known.try_emplace(sequence);
  if (is_new) block->second = make_block(sequence);
  return block->second;
}

FoundBlocks find_blocks(const std::filesystem::path& folder, Disk& disk) {
  FoundBlocks found;
  RecordReader reader(folder, disk);
  reader.finish();
  SealedBlock block;
  HeaderCheck headers;
  while (const auto event = reader.next()) {
    if (const auto from = headers.take(reader.segment(), reader.offset(), *event))
      found.altered_headers.push_back({.from = *from, .to = reader.offset()});
    found.event_bytes[reader.segment()] += kLogHeaderBytes + event->channel.size() + event->data.size();
    // By content: the channel's name may be what was damaged.
    if (accept(event->data, block) != Refusal::kNone) {
      const bool is_other = !event->channel.starts_with("RB_BLOCK_") && ends_with_its_crc(event->data);
      if (event->channel.starts_with("RB_") && !is_other) found.altered.push_back(reader.offset());
      continue;
    }
    const auto expected = numbered_block(block.header.sequence).bytes();
    if (!std::equal(expected.begin(), expected.end(), event->data.begin(), event->data.end()))
      ++found.false_blocks;
    if (block.header.sequence > 0) found.sequences.push_back(block.header.sequence);
  }
  found.damage = reader.damage();
  return found;
}

std::vector<std::int64_t> all_through(std::int64_t last) {
  std::vector<std::int64_t> sequences;
  for (std::int64_t k = 1; k <= last; ++k) sequences.push_back(k);
  return sequences;
}

Feeder::Feeder(RecordWriter::Options options, Disk& disk) : writer_(std::move(options), disk), base_(0) {
  const auto known = writer_.holds().epoch.find({kNode, kEpoch});
  if (known != writer_.holds().epoch.end()) base_ = known->second.position.contiguous;
  writer_.set_preamble([](const RecordState&) {
    const SealedBlock block = numbered_block(0);
    const auto about = block.bytes();
    return RecordEvents{{"RB_BLOCK_ABOUT", {about.begin(), about.end()}}};
  });
}

template <typename Call>
bool Feeder::attempt(Call&& call) {
  try {
    if (writer_.is_away() && !writer_.take_again()) throw_away();
    call();
    return true;
  } catch (const std::system_error& error) {
    ++failures_;
    if (error.code() == std::errc::no_such_device)
      writer_.let_go({});
    else
      writer_.abandon({});
    return false;
  }
}

bool Feeder::append_through(std::int64_t sequence) {
  failures_ = 0;
  while (appended() < sequence && failures_ < kMostFailures)
    attempt([this] { writer_.append(numbered_block(appended() + 1), 1000 * appended()); });
  return appended() >= sequence;
}

bool Feeder::sync() {
  const std::int64_t sequence = appended();
  for (int tries = 0; tries < kMostFailures; ++tries)
    if (append_through(sequence) && attempt([this] {
          writer_.sync();
          if (!writer_.is_at_its_place()) throw_away();
        }))
      return true;
  return false;
}

bool Feeder::close() {
  return sync() && attempt([this] { writer_.close(); });
}

}  // namespace roadbalance::test
