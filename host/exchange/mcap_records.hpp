#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace roadbalance {

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
  /// The present record ends here.
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

}  // namespace roadbalance
