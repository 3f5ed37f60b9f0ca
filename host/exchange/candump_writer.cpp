#include "host/exchange/candump_writer.hpp"

#include <array>
#include <cctype>
#include <cstdio>
#include <set>
#include <vector>

#include "common/config/section.hpp"
#include "common/text/format.hpp"
#include "host/exchange/byte_sink.hpp"
#include "host/exchange/only_group.hpp"

namespace roadbalance {
namespace {

/// A row of which nothing is there has one frame without data, so that a reader sees that there was a row.
constexpr std::size_t kNoSampleId = 0xFF;
constexpr std::size_t kStartId = 0xFE;
constexpr std::size_t kFirstId = 0x100, kIds = 0x800 - kFirstId;
constexpr const char* kInterface = "can0";

/// Up to what head_of() begins with.
std::string stamp_of(std::int64_t time_us) {
  constexpr std::int64_t kSecond_us = 1'000'000;
  return format("(%010lld.%06lld", static_cast<long long>(time_us / kSecond_us),
                static_cast<long long>(time_us % kSecond_us));
}

/// From the stamp to the data.
std::string head_of(std::size_t id) {
  return format(") %s %03zX#", kInterface, id);
}

/// Names of DBC files are those of C, no two alike.
std::vector<std::string> identifiers(const ExportGroup& group) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const ExportChannel& channel : group.channel) {
    std::string name = channel.name;
    for (char& c : name)
      if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())) != 0) name.insert(0, "_");
    while (!taken.insert(name).second) name += '_';
    names.push_back(name);
  }
  return names;
}

const ExportGroup& group_of(const ExportTable& table) {
  const ExportGroup& group = only_group(table, "candump");
  if (group.channel.size() > kIds)
    throw ConfigError("candump: " + std::to_string(group.channel.size()) + " channels; allowed: 1 .. " +
                      std::to_string(kIds) + " (--channels)");
  return group;
}

class CandumpWriter final : public ExportWriter {
 public:
  CandumpWriter(const std::filesystem::path& file, const ExportTable& table)
      : sink_(file), start_us_(table.start_utc_us.value_or(0)) {
    for (std::size_t c = 0; c < group_of(table).channel.size(); ++c) head_.push_back(head_of(kFirstId + c));
    sink_.put(stamp_of(start_us_) + head_of(kStartId) + "\n");
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
  /// The lowest byte first, and the end of the line.
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

std::string candump_dbc(const ExportTable& table) {
  const ExportGroup& group = group_of(table);
  const std::vector<std::string> names = identifiers(group);
  std::string text = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: roadbalance\n\n";
  text += format("BO_ %zu %s: 0 roadbalance\n\n", kStartId, kCandumpStart);
  text += format("BO_ %zu no_sample: 0 roadbalance\n\n", kNoSampleId);
  for (std::size_t c = 0; c < names.size(); ++c) {
    const ExportChannel& channel = group.channel[c];
    text += format("BO_ %zu %s: 4 roadbalance\n SG_ %s : 0|32@1- (%.17g,%.17g) [0|0] \"%s\" Vector__XXX\n\n",
                   kFirstId + c, names[c].c_str(), names[c].c_str(), channel.scale,
                   -channel.offset_counts * channel.scale, channel.unit.c_str());
  }
  return text;
}

}  // namespace roadbalance
