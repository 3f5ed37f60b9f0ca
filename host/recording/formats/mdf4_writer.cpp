#include "host/recording/formats/mdf4_writer.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "common/text/format.hpp"
#include "common/text/markup.hpp"
#include "host/recording/formats/byte_sink.hpp"

namespace roadbalance {
namespace {

/// Size of a block's header, without its links.
constexpr std::size_t kBlockHeader = 24;

/// Fields of a block, little endian, in order.
class Mdf4Fields {
 public:
  template <typename Number>
  requires std::is_arithmetic_v<Number> Mdf4Fields& operator<<(Number number) {
    std::array<std::uint8_t, sizeof number> bytes;
    std::memcpy(bytes.data(), &number, sizeof number);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  Mdf4Fields& zeros(std::size_t count) {
    bytes_.insert(bytes_.end(), count, 0);
    return *this;
  }
  Mdf4Fields& text(std::string_view text) {
    bytes_.insert(bytes_.end(), text.begin(), text.end());
    return *this;
  }
  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Blocks of an MDF4 file in memory, with links between them that may be set later.
///
/// A block: "##", two letters, 4 bytes 0, length, number of links (64 bits each, little endian), links, data;
/// it begins at a multiple of 8.  Source: ASAM MDF 4.1.0, section 4.
class Mdf4Blocks {
 public:
  using Position = std::uint64_t;

  /// Appends a block; links not yet known are 0.  @return its position in the file
  Position add(std::string_view id, std::vector<Position> links, std::span<const std::uint8_t> data);
  /// Adds text that ends with 0 (##TX), or XML (##MD).
  Position add_text(std::string_view text) { return add_zero_ended("TX", text); }
  Position add_xml(std::string_view text) { return add_zero_ended("MD", text); }
  void set_link(Position block, std::size_t link, Position to);

  /// Begins the file with the identification, which is no block; to be called first.
  void identify(std::string_view program);

  Position end() const { return bytes_.size(); }
  std::span<const std::uint8_t> bytes() const { return bytes_; }

 private:
  Position add_zero_ended(std::string_view id, std::string_view text);

  std::vector<std::uint8_t> bytes_;
};

void Mdf4Blocks::identify(std::string_view program) {
  Mdf4Fields id;
  std::string name(program.substr(0, 8));
  name.resize(8, ' ');
  id.text("MDF     ").text("4.10    ").text(name).zeros(4);
  id << std::uint16_t{410};
  id.zeros(30 + 2 + 2);  // finished: no flags
  bytes_.assign(id.bytes().begin(), id.bytes().end());
}

Mdf4Blocks::Position Mdf4Blocks::add(std::string_view id, std::vector<Position> links,
                                     std::span<const std::uint8_t> data) {
  const Position at = bytes_.size();
  Mdf4Fields block;
  block.text("##").text(id).zeros(4);
  block << std::uint64_t{kBlockHeader + 8 * links.size() + data.size()} << std::uint64_t{links.size()};
  for (const Position link : links) block << link;
  bytes_.insert(bytes_.end(), block.bytes().begin(), block.bytes().end());
  bytes_.insert(bytes_.end(), data.begin(), data.end());
  bytes_.resize((bytes_.size() + 7) / 8 * 8, 0);
  return at;
}

Mdf4Blocks::Position Mdf4Blocks::add_zero_ended(std::string_view id, std::string_view text) {
  std::vector<std::uint8_t> data(text.begin(), text.end());
  std::replace(data.begin(), data.end(), std::uint8_t{0}, std::uint8_t{' '});
  data.resize((text.size() + 8) / 8 * 8, 0);  // at least one zero
  return add(id, {}, data);
}

void Mdf4Blocks::set_link(Position block, std::size_t link, Position to) {
  std::memcpy(bytes_.data() + block + kBlockHeader + 8 * link, &to, sizeof to);
}

using Position = Mdf4Blocks::Position;

constexpr const char* kNamespace = " xmlns=\"http://www.asam.net/mdf/v4\"";
constexpr std::uint64_t kDataHeader = 24;

std::uint32_t record_bytes(const ExportGroup& group) {
  return static_cast<std::uint32_t>(sizeof(double) + sizeof(std::int32_t) * group.channel.size());
}
std::uint32_t invalidation_bytes(const ExportGroup& group) {
  return static_cast<std::uint32_t>((group.channel.size() + 7) / 8);
}
std::uint64_t data_bytes(const ExportGroup& group) {
  return static_cast<std::uint64_t>(group.rows) * (record_bytes(group) + invalidation_bytes(group));
}

/// All blocks but the data blocks.
class Mdf4Head {
 public:
  explicit Mdf4Head(const ExportTable& table) : start_ns_(table.start_utc_us.value_or(0) * 1000) {
    blocks_.identify("rbalance");
    const Position head = add_head(table);
    blocks_.set_link(head, 1, add_history(table));
    blocks_.set_link(head, 3, add_attachment(table));
    Position before = head;
    std::size_t link = 4;
    for (const auto& mark : table.mark) {
      const Position event = add_event(mark);
      blocks_.set_link(before, link, event);
      before = event;
      link = 0;
    }
    before = head;
    link = 0;
    for (const auto& group : table.group) {
      const Position data_group = add_group(group);
      blocks_.set_link(before, link, data_group);
      before = data_group;
      link = 0;
      data_group_.push_back(data_group);
    }
    place_data(table);
  }

  std::span<const std::uint8_t> bytes() const { return blocks_.bytes(); }

 private:
  Position add_head(const ExportTable& table) {
    Mdf4Fields fields;
    fields << start_ns_ << std::int16_t{0} << std::int16_t{0} << std::uint8_t{2} << std::uint8_t{0}
           << std::uint8_t{0} << std::uint8_t{0} << 0.0 << 0.0;
    const Position head = blocks_.add("HD", std::vector<Position>(6), fields.bytes());
    const std::string start = !table.start_utc_us    ? "The recording does not tell when it began."
                              : table.start_by_clock ? "Begin by the recorded clocks."
                                                     : "Begin by the arrival of the first samples.";
    blocks_.set_link(head, 5,
                     blocks_.add_xml(std::string("<HDcomment") + kNamespace + "><TX>Vehicle " +
                                     markup_text(table.vehicle) + ". " + start + "</TX></HDcomment>"));
    return head;
  }

  Position add_history(const ExportTable& table) {
    const Position comment = blocks_.add_xml(
        std::string("<FHcomment") + kNamespace + "><TX>Exported by rb export; recorded by " +
        markup_text(table.program.empty() ? "an unknown program" : table.program) +
        ".</TX><tool_id>rb</tool_id><tool_vendor>roadbalance</tool_vendor><tool_version>1</tool_version>"
        "</FHcomment>");
    Mdf4Fields fields;
    fields << start_ns_ << std::int16_t{0} << std::int16_t{0} << std::uint8_t{2};
    fields.zeros(3);
    return blocks_.add("FH", {0, comment}, fields.bytes());
  }

  Position add_attachment(const ExportTable& table) {
    const Position name = blocks_.add_text("vehicle.toml");
    const Position type = blocks_.add_text("application/toml");
    Mdf4Fields fields;
    fields << std::uint16_t{1} << std::uint16_t{0} << std::uint32_t{0};  // embedded
    fields.zeros(16);                                                    // no MD5
    fields << std::uint64_t{table.vehicle_toml.size()} << std::uint64_t{table.vehicle_toml.size()};
    fields.text(table.vehicle_toml);
    return blocks_.add("AT", {0, name, type, 0}, fields.bytes());
  }

  Position add_event(const ExportMark& mark) {
    const Position name =
        blocks_.add_text(mark.text.empty() ? "mark " + std::to_string(mark.number) : mark.text);
    Mdf4Fields fields;  // a marker at a point of time, set by the user
    fields << std::uint8_t{6} << std::uint8_t{1} << std::uint8_t{0} << std::uint8_t{4} << std::uint8_t{0};
    fields.zeros(3);
    fields << std::uint32_t{0} << std::uint16_t{0} << std::uint16_t{0} << mark.time_ns << 1e-9;
    return blocks_.add("EV", {0, 0, 0, name, 0}, fields.bytes());
  }

  Position add_group(const ExportGroup& group) {
    Mdf4Fields fields;
    fields << std::uint64_t{0} << static_cast<std::uint64_t>(group.rows) << std::uint16_t{0}
           << std::uint16_t{0} << std::uint32_t{0} << record_bytes(group) << invalidation_bytes(group);
    const Position channel_group =
        blocks_.add("CG", {0, 0, blocks_.add_text(group.name), 0, 0, 0}, fields.bytes());
    Position before = add_channel("time", "s", 2, 4, 0, 64, 0, 0, 0);
    blocks_.set_link(channel_group, 1, before);
    for (std::size_t c = 0; c < group.channel.size(); ++c) {
      const Position channel = add_measured(group.channel[c], static_cast<std::uint32_t>(c));
      blocks_.set_link(before, 0, channel);
      before = channel;
    }
    Mdf4Fields no_record_id;
    no_record_id << std::uint64_t{0};
    return blocks_.add("DG", {0, channel_group, 0, 0}, no_record_id.bytes());
  }

  Position add_measured(const ExportChannel& channel, std::uint32_t column) {
    Mdf4Fields linear;  // physical = value[0] + value[1] * raw
    linear << std::uint8_t{1} << std::uint8_t{0xFF} << std::uint16_t{0} << std::uint16_t{0}
           << std::uint16_t{2} << 0.0 << 0.0 << -channel.offset_counts * channel.scale << channel.scale;
    const Position conversion = blocks_.add("CC", std::vector<Position>(4), linear.bytes());
    const Eigen::Vector3d &at = channel.position_m, &to = channel.direction;
    const std::string about = format(
        "node %s, on %s at (%g, %g, %g) m, direction (%g, %g, %g), range %g %s, lags by %g s%s",
        channel.node.c_str(), channel.mount.c_str(), at.x(), at.y(), at.z(), to.x(), to.y(), to.z(),
        channel.range, channel.unit.c_str(), channel.delay_s, channel.overload ? "; left its range" : "");
    const Position comment = blocks_.add_xml(std::string("<CNcomment") + kNamespace + "><TX>" +
                                             markup_text(about) + "</TX></CNcomment>");
    return add_channel(channel.name, channel.unit, 0, 2, 8 + 4 * column, 32, column, conversion, comment);
  }

  /// @param type  0: fixed length, 2: master; @param data_type  2: signed integer, 4: float, little endian
  Position add_channel(const std::string& name, const std::string& unit, std::uint8_t type,
                       std::uint8_t data_type, std::uint32_t byte, std::uint32_t bits,
                       std::uint32_t invalid_bit, Position conversion, Position comment) {
    constexpr std::uint32_t kMayBeInvalid = 2;
    const bool master = type == 2;
    Mdf4Fields fields;
    fields << type << static_cast<std::uint8_t>(master ? 1 : 0) << data_type << std::uint8_t{0} << byte
           << bits << (master ? 0U : kMayBeInvalid) << invalid_bit << std::uint8_t{0xFF} << std::uint8_t{0}
           << std::uint16_t{0};
    fields.zeros(6 * sizeof(double));
    const Position name_at = blocks_.add_text(name);
    const Position unit_at = blocks_.add_text(unit);
    return blocks_.add("CN", {0, 0, name_at, 0, conversion, 0, unit_at, comment}, fields.bytes());
  }

  void place_data(const ExportTable& table) {
    Position at = blocks_.end();
    for (std::size_t g = 0; g < table.group.size(); ++g) {
      blocks_.set_link(data_group_[g], 2, at);
      at += (kDataHeader + data_bytes(table.group[g]) + 7) / 8 * 8;
    }
  }

  const std::int64_t start_ns_;
  Mdf4Blocks blocks_;
  std::vector<Position> data_group_;
};

class Mdf4Writer final : public ExportWriter {
 public:
  Mdf4Writer(const std::filesystem::path& file, const ExportTable& table) : sink_(file), group_(table.group) {
    sink_.put(Mdf4Head(table).bytes());
  }

  void add(std::size_t group, const ExportRows& rows) override {
    if (rows.first_row == 0) begin_data(group_[group]);
    const std::size_t columns = group_[group].channel.size();
    const std::size_t invalid = invalidation_bytes(group_[group]);
    record_.resize(record_bytes(group_[group]) + invalid);
    std::uint8_t* bits = record_.data() + record_.size() - invalid;
    for (std::size_t row = 0; row < rows.rows(); ++row) {
      const double time_s = static_cast<double>(rows.time_ns[row]) * 1e-9;
      const std::int32_t* counts = rows.counts.data() + row * columns;
      std::memcpy(record_.data(), &time_s, sizeof time_s);
      std::memcpy(record_.data() + sizeof time_s, counts, columns * sizeof *counts);
      std::fill_n(bits, invalid, std::uint8_t{0});
      for (std::size_t c = 0; c < columns; ++c)
        if (counts[c] == kMissingCounts) bits[c / 8] = static_cast<std::uint8_t>(bits[c / 8] | 1U << c % 8);
      sink_.put(std::span<const std::uint8_t>(record_));
    }
  }

  void close() override { sink_.close(); }

 private:
  void begin_data(const ExportGroup& group) {
    sink_.zeros((8 - sink_.offset() % 8) % 8);
    sink_.put(std::string_view("##DT\0\0\0\0", 8));
    sink_.put(std::uint64_t{kDataHeader + data_bytes(group)});
    sink_.put(std::uint64_t{0});
  }

  ByteSink sink_;
  const std::vector<ExportGroup> group_;
  std::vector<std::uint8_t> record_;
};

}  // namespace

std::unique_ptr<ExportWriter> make_mdf4_writer(const std::filesystem::path& file, const ExportTable& table) {
  return std::make_unique<Mdf4Writer>(file, table);
}

}  // namespace roadbalance
