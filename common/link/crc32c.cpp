#include "common/link/crc32c.hpp"

#include <array>
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

#if defined(__x86_64__)
bool processor_has_it() {
  return __builtin_cpu_supports("sse4.2") != 0;
}

__attribute__((target("sse4.2"))) std::uint32_t by_instruction(std::span<const std::uint8_t> bytes,
                                                               std::uint32_t before) {
  std::uint64_t value = ~before;
  std::size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, 8);
    value = _mm_crc32_u64(value, word);
  }
  auto narrow = static_cast<std::uint32_t>(value);
  for (; at < bytes.size(); ++at) narrow = _mm_crc32_u8(narrow, bytes[at]);
  return ~narrow;
}
#elif defined(__aarch64__)
bool processor_has_it() {
  return (getauxval(AT_HWCAP) & HWCAP_CRC32) != 0;
}

__attribute__((target("+crc"))) std::uint32_t by_instruction(std::span<const std::uint8_t> bytes,
                                                             std::uint32_t before) {
  std::uint32_t value = ~before;
  std::size_t at = 0;
  for (; at + 8 <= bytes.size(); at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, 8);
    value = __crc32cd(value, word);
  }
  for (; at < bytes.size(); ++at) value = __crc32cb(value, bytes[at]);
  return ~value;
}
#else
bool processor_has_it() {
  return false;
}

std::uint32_t by_instruction(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  return crc32c_by_table(bytes, before);
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

bool ends_with_its_crc(std::span<const std::uint8_t> bytes) {
  if (bytes.size() <= 4) return false;
  const std::uint8_t* last = bytes.data() + bytes.size() - 4;
  const std::uint32_t stored =
      std::uint32_t{last[0]} << 24 | std::uint32_t{last[1]} << 16 | std::uint32_t{last[2]} << 8 | last[3];
  return crc32c(bytes.first(bytes.size() - 4)) == stored;
}

}  // namespace roadbalance
