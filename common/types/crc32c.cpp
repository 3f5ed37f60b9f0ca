#include "common/types/crc32c.hpp"

#include <array>
#include <cassert>
#include <cstring>

#if defined(__x86_64__)
#include <nmmintrin.h>
#elif defined(__aarch64__)
#include <arm_acle.h>
#include <asm/hwcap.h>
#include <sys/auxv.h>
#endif

namespace roadbalance {
namespace {

constexpr std::uint32_t kPolynomial = 0x82F63B78u;

constexpr std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t value = byte;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) ? kPolynomial : 0);
    table[byte] = value;
  }
  return table;
}
constexpr auto kTable = make_table();

// Adding a word takes three cycles, but one can begin each cycle: three lanes side by side.  Three of these
// lengths are a scan block but for its last four bytes.
constexpr std::size_t kLaneBytes = 448;

// [k][b]: the value that byte k of the register, b, becomes by a lane of zeros; a CRC is linear, so that the
// four add.
using Shift = std::array<std::array<std::uint32_t, 256>, 4>;

constexpr std::uint32_t behind_zeros(std::uint32_t value, std::size_t bytes) {
  for (std::size_t k = 0; k < bytes; ++k) value = (value >> 8) ^ kTable[value & 0xFF];
  return value;
}

constexpr Shift make_shift() {
  Shift shift{};
  for (std::size_t k = 0; k < shift.size(); ++k) {
    for (std::size_t bit = 0; bit < 8; ++bit)
      shift[k][std::size_t{1} << bit] = behind_zeros(std::uint32_t{1} << (8 * k + bit), kLaneBytes);
    for (std::size_t b = 1; b < 256; ++b) shift[k][b] = shift[k][b & (b - 1)] ^ shift[k][b & (~b + 1)];
  }
  return shift;
}
constexpr auto kShift = make_shift();

[[maybe_unused]] std::uint32_t behind_lane(std::uint32_t value) {
  return kShift[0][value & 0xFF] ^ kShift[1][value >> 8 & 0xFF] ^ kShift[2][value >> 16 & 0xFF] ^
         kShift[3][value >> 24];
}

#if defined(__x86_64__)
#define RB_CRC_TARGET __attribute__((target("sse4.2")))
using Register = std::uint64_t;  // as the instruction has it; its upper half is 0

bool processor_has_it() {
  return __builtin_cpu_supports("sse4.2") != 0;
}

RB_CRC_TARGET inline Register add_word(Register value, std::uint64_t word) {
  return _mm_crc32_u64(value, word);
}

RB_CRC_TARGET inline Register add_byte(Register value, std::uint8_t byte) {
  return _mm_crc32_u8(static_cast<std::uint32_t>(value), byte);
}
#elif defined(__aarch64__)
#define RB_CRC_TARGET __attribute__((target("+crc")))
using Register = std::uint32_t;

bool processor_has_it() {
  return (getauxval(AT_HWCAP) & HWCAP_CRC32) != 0;
}

RB_CRC_TARGET inline Register add_word(Register value, std::uint64_t word) {
  return __crc32cd(value, word);
}

RB_CRC_TARGET inline Register add_byte(Register value, std::uint8_t byte) {
  return __crc32cb(value, byte);
}
#endif

#if defined(RB_CRC_TARGET)
std::uint64_t word_at(const std::uint8_t* bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, sizeof word);
  return word;
}

RB_CRC_TARGET inline Register add_four_bytes(Register value, const std::uint8_t* bytes) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes, sizeof word);
#if defined(__x86_64__)
  return _mm_crc32_u32(static_cast<std::uint32_t>(value), word);
#else
  return __crc32cw(value, word);
#endif
}

RB_CRC_TARGET Register add_three_lanes(Register first, const std::uint8_t* bytes) {
  Register second = 0;
  Register third = 0;
  for (std::size_t at = 0; at < kLaneBytes; at += 8) {
    first = add_word(first, word_at(bytes + at));
    second = add_word(second, word_at(bytes + kLaneBytes + at));
    third = add_word(third, word_at(bytes + 2 * kLaneBytes + at));
  }
  const std::uint32_t two =
      behind_lane(static_cast<std::uint32_t>(first)) ^ static_cast<std::uint32_t>(second);
  return behind_lane(two) ^ third;
}

RB_CRC_TARGET std::uint32_t by_instruction(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  Register value = ~before;
  std::size_t at = 0;
  for (; at + 3 * kLaneBytes <= bytes.size(); at += 3 * kLaneBytes)
    value = add_three_lanes(value, bytes.data() + at);
  for (; at + 8 <= bytes.size(); at += 8) value = add_word(value, word_at(bytes.data() + at));
  if (at + 4 <= bytes.size()) {
    value = add_four_bytes(value, bytes.data() + at);
    at += 4;
  }
  for (; at < bytes.size(); ++at) value = add_byte(value, bytes[at]);
  return ~static_cast<std::uint32_t>(value);
}

// The counts of a column in two rows, as if they followed one another.
std::uint64_t word_of_rows(const std::uint8_t* bytes, std::size_t row_bytes) {
  std::uint32_t upper = 0, lower = 0;
  std::memcpy(&upper, bytes, sizeof upper);
  std::memcpy(&lower, bytes + row_bytes, sizeof lower);
  return std::uint64_t{lower} << 32 | upper;
}

// Two rows of four columns at a time: each instruction has eight bytes, and the columns' chains run side by
// side in registers.  Then what that leaves over.
RB_CRC_TARGET void columns_by_instruction(std::span<const std::uint8_t> rows, std::span<std::uint32_t> crc) {
  const std::size_t row_bytes = kCrcColumnBytes * crc.size();
  const std::size_t pair_bytes = 2 * row_bytes;
  const std::size_t in_pairs = rows.size() / pair_bytes * pair_bytes;
  const std::size_t in_fours = crc.size() / 4 * 4;
  for (std::size_t k = 0; k < in_fours; k += 4) {
    Register a = ~crc[k], b = ~crc[k + 1], c = ~crc[k + 2], d = ~crc[k + 3];
    const std::uint8_t* at = rows.data() + kCrcColumnBytes * k;
    for (std::size_t done = 0; done < in_pairs; done += pair_bytes, at += pair_bytes) {
      a = add_word(a, word_of_rows(at, row_bytes));
      b = add_word(b, word_of_rows(at + kCrcColumnBytes, row_bytes));
      c = add_word(c, word_of_rows(at + 2 * kCrcColumnBytes, row_bytes));
      d = add_word(d, word_of_rows(at + 3 * kCrcColumnBytes, row_bytes));
    }
    crc[k] = ~static_cast<std::uint32_t>(a);
    crc[k + 1] = ~static_cast<std::uint32_t>(b);
    crc[k + 2] = ~static_cast<std::uint32_t>(c);
    crc[k + 3] = ~static_cast<std::uint32_t>(d);
  }
  for (std::size_t k = 0; k < crc.size(); ++k) {
    Register value = ~crc[k];
    for (std::size_t at = k < in_fours ? in_pairs : 0; at < rows.size(); at += row_bytes)
      value = add_four_bytes(value, rows.data() + at + kCrcColumnBytes * k);
    crc[k] = ~static_cast<std::uint32_t>(value);
  }
}
#else
bool processor_has_it() {
  return false;
}

std::uint32_t by_instruction(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  return crc32c_by_table(bytes, before);
}

void columns_by_instruction(std::span<const std::uint8_t> rows, std::span<std::uint32_t> crc) {
  crc32c_columns_by_table(rows, crc);
}
#endif

}  // namespace

bool crc32c_has_instruction() {
  static const bool has_it = processor_has_it();
  return has_it;
}

std::uint32_t crc32c_by_table(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  std::uint32_t value = ~before;
  for (const std::uint8_t byte : bytes) value = (value >> 8) ^ kTable[(value ^ byte) & 0xFF];
  return ~value;
}

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  return crc32c_has_instruction() ? by_instruction(bytes, before) : crc32c_by_table(bytes, before);
}

void crc32c_columns_by_table(std::span<const std::uint8_t> rows, std::span<std::uint32_t> crc) {
  for (std::size_t at = 0; at < rows.size();)
    for (std::size_t column = 0; column < crc.size(); ++column, at += kCrcColumnBytes)
      crc[column] = crc32c_by_table(rows.subspan(at, kCrcColumnBytes), crc[column]);
}

void crc32c_columns(std::span<const std::uint8_t> rows, std::span<std::uint32_t> crc) {
  assert(!crc.empty() && rows.size() % (kCrcColumnBytes * crc.size()) == 0);
  if (crc32c_has_instruction())
    columns_by_instruction(rows, crc);
  else
    crc32c_columns_by_table(rows, crc);
}

bool ends_with_its_crc(std::span<const std::uint8_t> bytes) {
  if (bytes.size() <= 4) return false;
  const std::uint8_t* last = bytes.data() + bytes.size() - 4;
  const std::uint32_t stored =
      std::uint32_t{last[0]} << 24 | std::uint32_t{last[1]} << 16 | std::uint32_t{last[2]} << 8 | last[3];
  return crc32c(bytes.first(bytes.size() - 4)) == stored;
}

}  // namespace roadbalance
