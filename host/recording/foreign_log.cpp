#include "host/recording/foreign_log.hpp"

#include <cstdint>
#include <string_view>

#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {
namespace {

constexpr std::string_view kOurChannels = "RB_";  ///< all begin so

}  // namespace

std::string foreign_words(const std::filesystem::path& folder, Disk& disk) {
  RecordReader reader(folder, disk);
  reader.finish();
  std::int64_t events = 0;
  std::string first;
  for (; const auto event = reader.next(); ++events) {
    if (event->channel.starts_with(kOurChannels)) return "";
    if (first.empty())
      first = "channel " + std::string(event->channel) + " from byte " + std::to_string(reader.offset()) +
              " of " + segment_path(folder, reader.segment()).filename().string();
  }
  if (events > 0)
    return std::to_string(events) + " events, but none of ours (" + first +
           "): an LCM log of another program";
  if (reader.damage().empty()) return "nothing was written into its segments";
  const auto& damage = reader.damage().front();
  return damage.segment.filename().string() + ": no event of an LCM log from byte " +
         std::to_string(damage.offset) + " on: a file of another program, or all of it is damaged";
}

}  // namespace roadbalance
