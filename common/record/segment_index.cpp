#include "common/record/segment_index.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <sstream>
#include <utility>

#include "common/bus/codec.hpp"
#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/record_state.hpp"
#include "common/record/segment.hpp"
#include "common/record/write_again.hpp"
#include "common/types/block.hpp"
#include "common/types/text_crc.hpp"

namespace roadbalance {
namespace {

std::string crc_line(std::string_view text) {
  char line[32];
  std::snprintf(line, sizeof line, "crc32c %08x\n", crc32c(text));
  return line;
}

std::string sum_word(const RecordState::Epoch& epoch) {
  if (!epoch.sum) return "none";
  char word[16];
  std::snprintf(word, sizeof word, "%08x", *epoch.sum);
  return word;
}

// Any other word is none, which encode() then shows.
std::optional<std::uint32_t> parse_sum(const std::string& word) {
  std::uint32_t sum = 0;
  const char* const end = word.data() + word.size();
  const auto parsed = std::from_chars(word.data(), end, sum, 16);
  if (word.empty() || parsed.ec != std::errc() || parsed.ptr != end) return std::nullopt;
  return sum;
}

// As on the wire: a receiver counts on from these.
bool in_bounds(const RecordState::Epoch& epoch) {
  for (const std::int64_t number :
       {epoch.position.contiguous, epoch.position.next_scan, epoch.samples, epoch.gaps, epoch.blocks})
    if (number < 0 || number > kIndexLimit) return false;
  return true;
}

}  // namespace

std::string encode(const SegmentIndex& index) {
  std::ostringstream text;
  text << "roadbalance index 2\nsegment " << index.segment << " bytes " << index.bytes << '\n';
  for (const auto& [key, epoch] : index.epoch)
    text << "epoch " << key.first << ' ' << key.second << " contiguous " << epoch.position.contiguous
         << " next_scan " << epoch.position.next_scan << " ended "
         << (epoch.position.crashed ? 2
             : epoch.position.ended ? 1
                                    : 0)
         << " samples " << epoch.samples << " gaps " << epoch.gaps << " blocks " << epoch.blocks << " sum "
         << sum_word(epoch) << '\n';
  return text.str() + crc_line(text.str());
}

std::optional<SegmentIndex> decode_index(std::string_view text) {
  SegmentIndex index;
  std::istringstream in{std::string(text)};
  std::string word;
  in >> word >> word >> word >> word >> index.segment >> word >> index.bytes;
  while (in >> word && word == "epoch") {
    NodeEpoch key;
    RecordState::Epoch epoch;
    int ended = 0;
    in >> key.first >> key.second >> word >> epoch.position.contiguous >> word >> epoch.position.next_scan >>
        word >> ended >> word >> epoch.samples >> word >> epoch.gaps >> word >> epoch.blocks >> word >> word;
    epoch.sum = parse_sum(word);
    epoch.position.ended = ended != 0;
    epoch.position.crashed = ended == 2;
    if (!in_bounds(epoch)) return std::nullopt;
    index.epoch[key] = epoch;
  }
  // One form only, and its CRC is in it.
  if (!in || encode(index) != text) return std::nullopt;
  return index;
}

std::filesystem::path index_path(const std::filesystem::path& folder, int number) {
  return segment_path(folder, number).replace_extension(".idx");
}

std::optional<SegmentIndex> read_index_alone(const std::filesystem::path& folder, int number, Disk& disk) {
  const auto text = read_text(index_path(folder, number), disk);
  if (!text) return std::nullopt;
  auto index = decode_index(*text);
  if (index && index->segment != number) return std::nullopt;
  return index;
}

std::optional<SegmentIndex> read_index(const std::filesystem::path& folder, int number, Disk& disk) {
  auto index = read_index_alone(folder, number, disk);
  const auto segment = segment_path(folder, number);
  if (!index || !path_exists(segment, disk) || size_of_file(segment, disk) != index->bytes)
    return std::nullopt;
  return index;
}

bool knows_of_more(const std::filesystem::path& folder, int number, Disk& disk) {
  const auto index = read_index_alone(folder, number, disk);
  return index && index->bytes > size_of_file(segment_path(folder, number), disk);
}

void write_index(const std::filesystem::path& folder, const SegmentIndex& index, Disk& disk) {
  write_atomically(index_path(folder, index.segment), encode(index), disk);
}

RecordBeginning beginning_of(const std::filesystem::path& folder, Disk& disk) {
  RecordBeginning begin{.before = std::nullopt,
                        .is_in_other_folder = path_exists(folder / kContinuesFile, disk)};
  const auto numbers = segment_numbers(folder, disk);
  if (numbers.empty()) return begin;
  int deleted = 0;
  for (const std::string& name : list_folder(folder, disk))
    if (const auto number = segment_of_file(name, ".idx"); number && *number < numbers.front())
      deleted = std::max(deleted, *number);
  if (deleted > 0)
    begin.before = read_index_alone(folder, deleted, disk);
  else if (numbers.front() == 1 && !begin.is_in_other_folder)
    begin.before.emplace();
  return begin;
}

int start_from_index(const std::filesystem::path& folder, RecordState& state, Disk& disk) {
  const auto take = [&state](const SegmentIndex& index) {
    for (const auto& [key, epoch] : index.epoch) {
      RecordState::Epoch& known = state.epoch[key];
      if (epoch.position.contiguous >= known.position.contiguous) known = epoch;
    }
  };
  const auto numbers = segment_numbers(folder, disk);
  if (numbers.empty()) return 1;
  for (auto number = numbers.rbegin(); number != numbers.rend(); ++number)
    if (const auto index = read_index(folder, *number, disk)) {
      take(*index);
      return *number + 1;
    }
  if (const auto before = beginning_of(folder, disk).before) take(*before);
  return numbers.front();
}

RecordEnd end_of_record(const std::filesystem::path& folder, int first, Disk& disk) {
  RecordEnd end;
  const auto numbers = segment_numbers(folder, disk);
  for (auto number = numbers.rbegin(); number != numbers.rend(); ++number) {
    end.last = *number;
    if (read_index(folder, *number, disk)) break;  // it was finished: damage in it is damage
    const SegmentExtent extent = measure_segment(segment_path(folder, *number), disk);
    end.unfinished.push_back({*number, extent});
    if (extent.end > 0 || *number <= first) break;
  }
  return end;
}

namespace {

// Where the record stands at the end of a finished segment, which has no good index.
std::optional<SegmentIndex> index_anew(const std::filesystem::path& folder, int number, Disk& disk) {
  const auto before = beginning_of(folder, disk).before;
  if (!before) return std::nullopt;
  RecordState state;
  state.epoch = before->epoch;
  RecordReader reader(folder, disk);
  SealedBlock block;
  for (auto event = reader.next(); event && reader.segment() <= number; event = reader.next())
    if (accept(*event, block) == Refusal::kNone) add(block, state);
  return SegmentIndex{.segment = number,
                      .bytes = size_of_file(segment_path(folder, number), disk),
                      .epoch = std::move(state.epoch)};
}

}  // namespace

RebuiltIndexes rebuild_indexes(const std::filesystem::path& folder, Disk& disk) {
  RebuiltIndexes rebuilt;
  const auto numbers = segment_numbers(folder, disk);
  if (numbers.empty()) return rebuilt;
  RecordState state;
  bool is_known = false;  // what the segments so far come to
  if (const auto before = beginning_of(folder, disk).before) {
    state.epoch = before->epoch;
    is_known = true;
  }
  // A segment with an index counts as durable; for the last one that is not certain.
  for (const auto& [number, extent] : end_of_record(folder, 1, disk).unfinished) {
    const auto path = segment_path(folder, number);
    if (extent.end < extent.size) {
      rebuilt.torn.push_back(path);
      continue;
    }
    File last = File::open_to_write(path, disk);
    write_again(last, 0, disk);
  }
  const auto at_end = [&](int segment, const RecordState& at) {
    if (std::ranges::find(rebuilt.torn, segment_path(folder, segment)) != rebuilt.torn.end()) return;
    if (knows_of_more(folder, segment, disk)) return;
    if (!is_known) {
      if (const auto good = read_index(folder, segment, disk)) {
        state.epoch = good->epoch;
        is_known = true;
      } else {
        rebuilt.unknown.push_back(segment_path(folder, segment));
      }
      return;
    }
    const SegmentIndex index{
        .segment = segment, .bytes = size_of_file(segment_path(folder, segment), disk), .epoch = at.epoch};
    if (read_index(folder, segment, disk) == index) return;
    write_index(folder, index, disk);
    ++rebuilt.written;
  };
  read_segments(folder, numbers.front(), state, at_end, disk);
  return rebuilt;
}

void delete_segment(const std::filesystem::path& folder, int number, Disk& disk) {
  if (!read_index(folder, number, disk) && !knows_of_more(folder, number, disk))
    if (const auto index = index_anew(folder, number, disk)) write_index(folder, *index, disk);
  remove_file(segment_path(folder, number), disk);
  for (const std::string& name : list_folder(folder, disk))
    if (const auto before = segment_of_file(name, ".idx"); before && *before < number)
      remove_file(index_path(folder, *before), disk);
  sync_folder(folder, disk);
}

}  // namespace roadbalance
