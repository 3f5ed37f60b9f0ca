#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace roadbalance {

/// CRC-32C (Castagnoli, reflected polynomial 0x82F63B78), as in RFC 3720 appendix B.4.
///
/// Uses the processor's instruction where it has one (SSE 4.2, ARMv8 CRC), else a table; chosen once at run
/// time.  Never allocates.
/// @param before  the result for the bytes that come before these; 0 at the beginning
std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

/// The same by table only: the fallback, and the instruction's independent check.
std::uint32_t crc32c_by_table(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

inline constexpr std::size_t kCrcColumnBytes = 4;

/// Rows of crc.size() columns of four bytes each: every column's CRC goes on from crc[column].
void crc32c_columns(std::span<const std::uint8_t> rows, std::span<std::uint32_t> crc);
void crc32c_columns_by_table(std::span<const std::uint8_t> rows, std::span<std::uint32_t> crc);

/// The form of all messages we record: the last four bytes are the CRC of those before, big endian.
bool ends_with_its_crc(std::span<const std::uint8_t> bytes);

/// True if crc32c() uses the processor's instruction.
bool crc32c_has_instruction();

}  // namespace roadbalance
