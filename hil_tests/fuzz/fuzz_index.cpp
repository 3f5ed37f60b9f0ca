#include <cstdio>
#include <string>

#include "common/record/segment_index.hpp"
#include "common/types/crc32c.hpp"
#include "hil_tests/fuzz/property.hpp"

namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached indexes("an index");

void check(const std::string& text) {
  const auto index = decode_index(text);
  if (!index) return;
  indexes.count();
  require(encode(*index) == text, "an index has one form");
  require(decode_index(encode(*index)) == index, "what was accepted is accepted again");
}

// The text with its last line made good.
std::string mended(std::string text) {
  const auto line = text.rfind("crc32c ");
  text.resize(line == std::string::npos ? text.size() : line);
  char crc[32];
  std::snprintf(crc, sizeof crc, "crc32c %08x\n",
                crc32c({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
  return text + crc;
}

}  // namespace
}  // namespace roadbalance

// A segment's index: as it came, and with a good CRC.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  roadbalance::check(text);
  roadbalance::check(roadbalance::mended(text));
  return 0;
}
