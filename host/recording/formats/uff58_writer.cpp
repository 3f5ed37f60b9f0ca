#include "host/recording/formats/uff58_writer.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <ctime>
#include <string>
#include <vector>

#include "common/record/file.hpp"
#include "common/text/format.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kPerLine = 4;
constexpr std::size_t kNumber = 20;  ///< characters: E20.12

/// At most 80 characters of ASCII, and never empty: NONE is the format's empty line.
std::string line(const std::string& text) {
  std::string printable;
  for (const char c : text.substr(0, 80)) printable += c >= ' ' && c <= '~' ? c : '_';
  return (printable.empty() ? "NONE" : printable) + "\n";
}

/// "22-Nov-26 19:20:00", or NONE.
std::string date(const std::optional<std::int64_t>& utc_us) {
  if (!utc_us) return "NONE";
  const std::time_t seconds = static_cast<std::time_t>(*utc_us / 1'000'000);
  std::tm utc{};
  std::array<char, 32> text{};
  if (gmtime_r(&seconds, &utc) == nullptr) return "NONE";
  return {text.data(), std::strftime(text.data(), text.size(), "%d-%b-%y %H:%M:%S", &utc)};
}

struct Specific {
  int type, length_exponent;
  const char *label, *unit;
};
Specific specific_of(const ExportChannel& channel) {
  if (channel.unit == "m/s^2") return {12, 1, "Acceleration", "m/s^2"};
  if (channel.unit == "m") return {8, 1, "Displacement", "m"};
  return {0, 0, "NONE", "NONE"};
}

/// +-1 .. 3 for x, y, z, 0 for any other.
int direction_of(const ExportChannel& channel) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(std::abs(channel.direction[axis]) - 1.0) < 1e-6)
      return channel.direction[axis] > 0 ? axis + 1 : -axis - 1;
  return 0;
}

std::string axis(int type, int length, const char* label, const char* unit) {
  return format("%10d%5d%5d%5d %-20s %-20s\n", type, length, 0, 0, label, unit);
}

std::string head(const ExportTable& table, const ExportGroup& group, const ExportChannel& channel,
                 int number) {
  const double period_s = 1.0 / group.rate_hz;
  const Specific specific = specific_of(channel);
  std::string text = "    -1\n    58\n";
  text += line(channel.name);
  text += line("Vehicle " + table.vehicle + ", node " + channel.node + ", on " + channel.mount);
  text += line(date(table.start_utc_us));
  text += line(format("Rate %.15g Hz, first sample at %.9f s", group.rate_hz,
                      static_cast<double>(group.first_ns) * 1e-9));
  text += line(channel.overload ? "The channel left its range" : "NONE");
  text += format("%5d%10d%5d%10d %-10.10s%10d%4d %-10s%10d%4d\n", 1, number, 0, 0, channel.node.c_str(),
                 number, direction_of(channel), "NONE", 0, 0);
  text += format("%10d%10lld%10d%13.5E%13.5E%13.5E\n", 4, static_cast<long long>(group.rows), 1,
                 static_cast<double>(group.first_ns) * 1e-9, period_s, 0.0);
  text += axis(17, 0, "Time", "s");
  text += axis(specific.type, specific.length_exponent, specific.label, specific.unit);
  text += axis(0, 0, "NONE", "NONE");
  text += axis(0, 0, "NONE", "NONE");
  return text;
}

std::string header_sets(const ExportTable& table) {
  std::string text = "    -1\n   151\n" + line("rb export");
  text += line("Vehicle " + table.vehicle) + line(table.program);
  text += format("%-10.9s%-10.9s%10d%10d%10d\n", date(table.start_utc_us).c_str(), "", 0, 0, 0);
  text += format("%-10.9s%-10.9s\n%-80s\n%-10.9s%-10.9s\n    -1\n", "", "", "roadbalance", "", "");
  text += "    -1\n   164\n";
  text += format("%10d%-20s%10d\n", 1, "SI: Meter (newton)", 2);
  text += "  1.00000000000000000D+00  1.00000000000000000D+00  1.00000000000000000D+00\n";
  text += "  2.73149999999999977D+02\n    -1\n";
  return text;
}

constexpr std::string_view kEnd = "    -1\n";

class Uff58Writer final : public ExportWriter {
 public:
  Uff58Writer(const std::filesystem::path& file, const ExportTable& table)
      : group_(table.group), file_(File::create(file)) {
    append(header_sets(table));
    int number = 0;
    for (const auto& group : table.group) {
      auto& places = place_.emplace_back();
      for (const auto& channel : group.channel) {
        append(head(table, group, channel, ++number));
        places.push_back(end_);
        const auto rows = static_cast<std::uint64_t>(group.rows);
        end_ += rows * kNumber + (rows + kPerLine - 1) / kPerLine;  // each line ends with a newline
        append(kEnd);
      }
    }
  }

  void add(std::size_t group, const ExportRows& rows) override {
    const auto& channels = group_[group].channel;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      text_.clear();
      for (std::size_t row = 0; row < rows.rows(); ++row) {
        const std::int64_t at = rows.first_row + static_cast<std::int64_t>(row);
        put(channels[c], rows.counts[row * channels.size() + c]);
        if (static_cast<std::size_t>(at) % kPerLine == kPerLine - 1 || at + 1 == group_[group].rows)
          text_ += '\n';
      }
      const auto first = static_cast<std::uint64_t>(rows.first_row);
      write_at(place_[group][c] + first * kNumber + first / kPerLine, text_);
    }
  }

  void close() override { file_.close(); }

 private:
  void put(const ExportChannel& channel, std::int32_t counts) {
    std::array<char, 32> digits;
    char* end = digits.data();
    if (counts == kMissingCounts)
      end = std::copy_n("NaN", 3, end);
    else
      end = std::to_chars(end, end + digits.size(), channel.value(counts), std::chars_format::scientific, 12)
                .ptr;
    const auto size = static_cast<std::size_t>(end - digits.data());
    text_.append(kNumber - size, ' ').append(digits.data(), size);
  }

  void append(std::string_view text) {
    write_at(end_, text);
    end_ += text.size();
  }
  void write_at(std::uint64_t offset, std::string_view text) {
    file_.write_all_at(offset, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  }

  const std::vector<ExportGroup> group_;
  File file_;
  std::uint64_t end_ = 0;
  std::vector<std::vector<std::uint64_t>> place_;  ///< [group][channel] of the first number
  std::string text_;
};

}  // namespace

std::unique_ptr<ExportWriter> make_uff58_writer(const std::filesystem::path& file, const ExportTable& table) {
  return std::make_unique<Uff58Writer>(file, table);
}

}  // namespace roadbalance
