#include "host/recording/formats/candump_writer.hpp"

#include <array>
#include <cctype>
#include <cstdio>
#include <set>
#include <vector>

#include "common/config/section.hpp"
#include "common/text/format.hpp"
#include "host/recording/formats/byte_sink.hpp"
#include "host/recording/formats/only_group.hpp"

namespace roadbalance {
namespace {

/// A row without any sample has one frame without data, so that a reader sees that there was a row.
constexpr std::size_t kNoSampleId = 0xFF;
constexpr std::size_t kStartId = 0xFE;
constexpr std::size_t kFirstId = 0x100, kIds = 0x800 - kFirstId;
constexpr const char* kInterface = "can0";
constexpr const char* kProgram = "roadbalance";

/// The text before head_of().
std::string stamp_of(std::int64_t time_us) {
  constexpr std::int64_t kSecond_us = 1'000'000;
  return format("(%010lld.%06lld", static_cast<long long>(time_us / kSecond_us),
                static_cast<long long>(time_us % kSecond_us));
}

/// The text from the stamp to the data.
std::string head_of(std::size_t id) {
  return format(") %s %03zX#", kInterface, id);
}

/// The names of the channels, no two alike.
std::vector<std::string> identifiers(const ExportGroup& group) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const ExportChannel& channel : group.channel) {
    std::string name = dbc_identifier(channel.name);
    while (!taken.insert(name).second) name += '_';
    names.push_back(name);
  }
  return names;
}

const ExportGroup& group_of(const ExportTable& table) {
  const ExportGroup& group = only_group(table, "candump");
  for (const ExportChannel& channel : group.channel)
    if (channel.number >= kIds)
      throw ConfigError("candump: channel " + channel.name + " is number " +
                        std::to_string(channel.number + 1) + " of the vehicle; allowed: 1 .. " +
                        std::to_string(kIds) + " (--channels)");
  return group;
}

class CandumpWriter final : public ExportWriter {
 public:
  CandumpWriter(const std::filesystem::path& file, const ExportTable& table)
      : sink_(file), start_us_(table.start_utc_us.value_or(0)) {
    for (const ExportChannel& channel : group_of(table).channel)
      head_.push_back(head_of(kFirstId + channel.number));
    sink_.put(stamp_of(start_us_) + head_of(kStartId));
    sink_.put(bytes(static_cast<std::int32_t>(table.meaning_crc32c)));
  }

  void add(std::size_t, const ExportRows& rows) override {
    const std::int32_t* counts = rows.counts.data();
    for (const std::int64_t time_ns : rows.time_ns) {
      const std::string stamp = stamp_of(start_us_ + (time_ns + 500) / 1000);
      bool is_there = false;
      for (const std::string& head : head_) {
        const std::int32_t value = *counts++;
        if (value == kMissingCounts) continue;
        is_there = true;
        sink_.put(stamp);
        sink_.put(head);
        sink_.put(bytes(value));
      }
      if (!is_there) sink_.put(stamp + head_of(kNoSampleId) + "\n");
    }
  }

  void close() override { sink_.close(); }

 private:
  /// Appends counts, lowest byte first, and the end of the line.
  std::string_view bytes(std::int32_t value) {
    constexpr const char* kDigits = "0123456789ABCDEF";
    const auto bits = static_cast<std::uint32_t>(value);
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t byte = bits >> (8 * i) & 0xFFU;
      text_[2 * i] = kDigits[byte >> 4];
      text_[2 * i + 1] = kDigits[byte & 0xFU];
    }
    return {text_.data(), text_.size()};
  }

  ByteSink sink_;
  const std::int64_t start_us_;
  std::vector<std::string> head_;  // [channel]
  std::array<char, 9> text_{'0', '0', '0', '0', '0', '0', '0', '0', '\n'};
};

}  // namespace

std::unique_ptr<ExportWriter> make_candump_writer(const std::filesystem::path& file,
                                                  const ExportTable& table) {
  return std::make_unique<CandumpWriter>(file, table);
}

std::string dbc_identifier(std::string name) {
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())) != 0) name.insert(0, "_");
  return name;
}

std::string candump_dbc(const ExportTable& table) {
  const ExportGroup& group = group_of(table);
  const std::vector<std::string> names = identifiers(group);
  std::set<std::string> nodes;
  for (const ExportChannel& channel : group.channel) nodes.insert(dbc_identifier(channel.node));
  nodes.erase(kProgram);
  std::string text = format("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: %s", kProgram);
  for (const std::string& node : nodes) text += " " + node;
  text += format("\n\nBO_ %zu %s: 4 %s\n SG_ %s : 0|32@1+ (1,0) [%u|%u] \"\" Vector__XXX\n\n", kStartId,
                 kCandumpStart, kProgram, kCandumpMeaning, table.meaning_crc32c, table.meaning_crc32c);
  text += format("BO_ %zu no_sample: 0 %s\n\n", kNoSampleId, kProgram);
  for (std::size_t c = 0; c < names.size(); ++c) {
    const ExportChannel& channel = group.channel[c];
    text +=
        format("BO_ %zu %s: 4 %s\n SG_ %s : 0|32@1- (%.17g,%.17g) [0|0] \"%s\" Vector__XXX\n\n",
               kFirstId + channel.number, names[c].c_str(), dbc_identifier(channel.node).c_str(),
               names[c].c_str(), channel.scale, -channel.offset_counts * channel.scale, channel.unit.c_str());
  }
  return text;
}

}  // namespace roadbalance
