#include "host/recording/formats/mcap_writer.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "host/recording/formats/byte_sink.hpp"
#include "host/recording/formats/description_json.hpp"

namespace roadbalance {
namespace {

/// Records of an MCAP file as bytes: opcode, length (64 bits), fields, little endian.
/// Source: MCAP file format specification, version 0 (mcap.dev/spec).
class McapRecords {
 public:
  enum class Opcode : std::uint8_t {
    kHeader = 1,
    kFooter,
    kSchema,
    kChannel,
    kMessage,
    kChunk,
    kMessageIndex,
    kChunkIndex,
    kAttachment,
    kAttachmentIndex,
    kStatistics,
    kMetadata,
    kMetadataIndex,
    kSummaryOffset,
    kDataEnd,
  };

  /// Begins a record; ends the one before.
  McapRecords& record(Opcode opcode) {
    finish();
    bytes_.push_back(static_cast<std::uint8_t>(opcode));
    length_at_ = bytes_.size();
    return put(std::uint64_t{0});
  }
  template <typename Number>
  requires std::is_arithmetic_v<Number> McapRecords& put(Number number) {
    std::array<std::uint8_t, sizeof number> bytes;
    std::memcpy(bytes.data(), &number, sizeof number);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  /// Its length (32 bits) and its bytes.
  McapRecords& put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  McapRecords& put_bytes(std::span<const std::uint8_t> bytes) {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  /// Ends the current record.
  void finish() {
    if (length_at_ == 0) return;
    const std::uint64_t length = bytes_.size() - length_at_ - sizeof(std::uint64_t);
    std::memcpy(bytes_.data() + length_at_, &length, sizeof length);
    length_at_ = 0;
  }
  void clear() {
    bytes_.clear();
    length_at_ = 0;
  }
  std::span<const std::uint8_t> bytes() const { return bytes_; }
  std::size_t size() const { return bytes_.size(); }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t length_at_ = 0;  ///< of the record begun; 0: none is
};

using Opcode = McapRecords::Opcode;
constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::uint32_t kLittleEndianCdr = 0x00000100;  ///< bytes 0, 1, 0, 0

std::uint32_t crc_of(std::span<const std::uint8_t> bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(crc32_z(before, bytes.data(), bytes.size()));
}

/// A field's name in ROS 2: small letters, digits and single _, beginning with a letter.
std::string field_name(const std::string& name, std::set<std::string>& taken) {
  std::string valid;
  for (char c : name) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const bool allowed = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    if (allowed || (!valid.empty() && valid.back() != '_')) valid += allowed ? c : '_';
  }
  while (!valid.empty() && valid.back() == '_') valid.pop_back();
  if (valid.empty() || valid.front() < 'a') valid.insert(0, "x");
  std::string unique = valid;
  for (int n = 2; !taken.insert(unique).second; ++n) unique = valid + "_" + std::to_string(n);
  return unique;
}

std::string schema_text(const ExportGroup& group) {
  std::string text;
  std::set<std::string> taken;
  for (const auto& channel : group.channel)
    text += "float64 " + field_name(channel.name, taken) + "  # " + channel.unit + "\n";
  return text;
}

class McapWriter final : public ExportWriter {
 public:
  McapWriter(const std::filesystem::path& file, const ExportTable& table)
      : table_(table), start_ns_(table.start_utc_us.value_or(0) * 1000), sink_(file) {
    sink_.put(kMagic);
    McapRecords head;
    head.record(Opcode::kHeader).put("ros2").put("roadbalance").finish();
    sink_.put(head.bytes());
    put_attachment();
    put_metadata();
    const McapRecords described = descriptions();
    sink_.put(described.bytes());
    put_marks();
  }

  void add(std::size_t group, const ExportRows& rows) override {
    const auto& channels = table_.group[group].channel;
    begin_chunk(static_cast<std::uint16_t>(group + 1));
    for (std::size_t row = 0; row < rows.rows(); ++row) {
      begin_message(rows.time_ns[row],
                    static_cast<std::uint32_t>(rows.first_row + static_cast<std::int64_t>(row)));
      for (std::size_t c = 0; c < channels.size(); ++c) {
        const std::int32_t counts = rows.counts[row * channels.size() + c];
        chunk_.put(counts == kMissingCounts ? std::numeric_limits<double>::quiet_NaN()
                                            : channels[c].value(counts));
      }
    }
    end_chunk();
  }

  void close() override {
    McapRecords end;
    end.record(Opcode::kDataEnd).put(std::uint32_t{0}).finish();
    sink_.put(end.bytes());
    const std::uint64_t begin = sink_.offset();
    McapRecords summary = descriptions();
    put_statistics(summary);
    summary.put_bytes(index_.bytes());
    // The CRC covers the footer up to itself.
    McapRecords footer;
    footer.record(Opcode::kFooter).put(begin).put(std::uint64_t{0}).put(std::uint32_t{0}).finish();
    const auto covered = footer.bytes().first(footer.size() - sizeof(std::uint32_t));
    const std::uint32_t crc = crc_of(covered, crc_of(summary.bytes()));
    sink_.put(summary.bytes());
    sink_.put(covered);
    sink_.put(crc);
    sink_.put(kMagic);
    sink_.close();
  }

 private:
  std::uint64_t log_time(std::int64_t time_ns) const {
    return static_cast<std::uint64_t>(start_ns_ + time_ns);
  }
  std::uint16_t marks_channel() const { return static_cast<std::uint16_t>(table_.group.size() + 1); }

  /// Schemas and channels, which stand both before the messages and in the summary.
  McapRecords descriptions() const {
    McapRecords records;
    const auto describe = [&](std::uint16_t id, const std::string& topic, const std::string& type,
                              const std::string& schema) {
      records.record(Opcode::kSchema).put(id).put("roadbalance/msg/" + type).put("ros2msg").put(schema);
      records.record(Opcode::kChannel).put(id).put(id).put("/" + topic).put("cdr").put(std::uint32_t{0});
    };
    std::uint16_t id = 0;
    for (const auto& group : table_.group) {
      ++id;
      describe(id, group.name, "Samples" + std::to_string(id), schema_text(group));
    }
    if (!table_.mark.empty()) describe(marks_channel(), "marks", "Mark", "int64 number\nstring text\n");
    records.finish();
    return records;
  }

  void put_attachment() {
    McapRecords content;
    content.record(Opcode::kAttachment)
        .put(log_time(0))
        .put(log_time(0))
        .put("vehicle.toml")
        .put("application/toml");
    content.put(std::uint64_t{table_.vehicle_toml.size()});
    content.put_bytes(
        {reinterpret_cast<const std::uint8_t*>(table_.vehicle_toml.data()), table_.vehicle_toml.size()});
    constexpr std::size_t kBefore = 9;  // opcode and length, which the CRC leaves out
    content.put(crc_of(content.bytes().subspan(kBefore))).finish();
    index_.record(Opcode::kAttachmentIndex).put(sink_.offset()).put(std::uint64_t{content.size()});
    index_.put(log_time(0)).put(log_time(0)).put(std::uint64_t{table_.vehicle_toml.size()});
    index_.put("vehicle.toml").put("application/toml").finish();
    sink_.put(content.bytes());
  }

  void put_metadata() {
    const std::string json = description_json(table_);
    McapRecords content;
    content.record(Opcode::kMetadata).put("description");
    content.put(static_cast<std::uint32_t>(4 + 4 + 4 + json.size())).put("json").put(json).finish();
    index_.record(Opcode::kMetadataIndex)
        .put(sink_.offset())
        .put(std::uint64_t{content.size()})
        .put("description")
        .finish();
    sink_.put(content.bytes());
  }

  void put_marks() {
    if (table_.mark.empty()) return;
    begin_chunk(marks_channel());
    for (const auto& mark : table_.mark) {
      begin_message(mark.time_ns, static_cast<std::uint32_t>(count_[marks_channel() - 1U]));
      const std::string zero_ended = mark.text + '\0';
      chunk_.put(mark.number).put(zero_ended);
    }
    end_chunk();
  }

  void begin_chunk(std::uint16_t channel) {
    chunk_.clear();
    message_.clear();
    channel_ = channel;
    count_.resize(table_.group.size() + 1);
  }

  void begin_message(std::int64_t time_ns, std::uint32_t sequence) {
    chunk_.finish();
    message_.push_back({log_time(time_ns), chunk_.size()});
    ++count_[channel_ - 1U];
    chunk_.record(Opcode::kMessage).put(channel_).put(sequence);
    chunk_.put(log_time(time_ns)).put(log_time(time_ns)).put(kLittleEndianCdr);
  }

  void end_chunk() {
    chunk_.finish();
    const auto [first, last] = std::minmax_element(message_.begin(), message_.end());
    first_time_ = std::min(first_time_, first->first);
    last_time_ = std::max(last_time_, last->first);
    const std::uint64_t begin = sink_.offset();
    head_.clear();
    head_.record(Opcode::kChunk).put(first->first).put(last->first).put(std::uint64_t{chunk_.size()});
    head_.put(crc_of(chunk_.bytes()))
        .put("")
        .put(std::uint64_t{chunk_.size()})
        .put_bytes(chunk_.bytes())
        .finish();
    const std::uint64_t length = head_.size();
    sink_.put(head_.bytes());
    const std::uint64_t index_at = sink_.offset();
    head_.clear();
    head_.record(Opcode::kMessageIndex).put(channel_).put(static_cast<std::uint32_t>(16 * message_.size()));
    for (const auto& [time, offset] : message_) head_.put(time).put(offset);
    head_.finish();
    sink_.put(head_.bytes());
    index_.record(Opcode::kChunkIndex).put(first->first).put(last->first).put(begin).put(length);
    index_.put(std::uint32_t{2 + 8}).put(channel_).put(index_at).put(std::uint64_t{head_.size()});
    index_.put("").put(std::uint64_t{chunk_.size()}).put(std::uint64_t{chunk_.size()}).finish();
    ++chunks_;
  }

  void put_statistics(McapRecords& summary) {
    count_.resize(table_.group.size() + 1);
    const auto channels = static_cast<std::uint16_t>(table_.group.size() + (table_.mark.empty() ? 0 : 1));
    std::uint64_t messages = 0;
    for (const std::uint64_t count : count_) messages += count;
    summary.record(Opcode::kStatistics).put(messages).put(channels).put(std::uint32_t{channels});
    summary.put(std::uint32_t{1}).put(std::uint32_t{1}).put(chunks_);
    summary.put(messages == 0 ? std::uint64_t{0} : first_time_).put(last_time_);
    summary.put(static_cast<std::uint32_t>(10 * channels));
    for (std::uint16_t id = 1; id <= channels; ++id) summary.put(id).put(count_[id - 1U]);
    summary.finish();
  }

  const ExportTable table_;
  const std::int64_t start_ns_;
  ByteSink sink_;
  McapRecords chunk_, head_, index_;
  std::uint16_t channel_ = 0;                                     ///< of the chunk
  std::vector<std::pair<std::uint64_t, std::uint64_t>> message_;  ///< of the chunk: log time, offset
  std::vector<std::uint64_t> count_;                              ///< messages by channel
  std::uint64_t first_time_ = std::numeric_limits<std::uint64_t>::max(), last_time_ = 0;
  std::uint32_t chunks_ = 0;
};

}  // namespace

std::unique_ptr<ExportWriter> make_mcap_writer(const std::filesystem::path& file, const ExportTable& table) {
  return std::make_unique<McapWriter>(file, table);
}

}  // namespace roadbalance
