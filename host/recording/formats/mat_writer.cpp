#include "host/recording/formats/mat_writer.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "common/config/section.hpp"
#include "common/record/file.hpp"
#include "host/recording/formats/description_json.hpp"

namespace roadbalance {
namespace {

/// Types of data elements, and classes of arrays.
enum : std::uint32_t { kInt8 = 1, kUint16 = 4, kInt32 = 5, kUint32 = 6, kDouble = 9, kMatrix = 14 };
enum : std::uint32_t { kCharacters = 4, kDoubles = 6 };
constexpr std::uint64_t kMostVariableBytes = (std::uint64_t{1} << 31) - 1;  ///< of a variable

constexpr std::uint64_t padded(std::uint64_t bytes) {
  return (bytes + 7) / 8 * 8;
}

class Bytes {
 public:
  void put(std::uint32_t number) { put(&number, sizeof number); }
  void put(const void* from, std::size_t size) {
    const auto* bytes = static_cast<const std::uint8_t*>(from);
    bytes_.insert(bytes_.end(), bytes, bytes + size);
  }
  void pad() { bytes_.resize(padded(bytes_.size())); }
  std::span<const std::uint8_t> all() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

std::vector<std::uint8_t> file_header() {
  std::string text = "MATLAB 5.0 MAT-file, written by roadbalance";
  text.resize(116, ' ');
  text.resize(124, '\0');  // no subsystem data
  text += std::string("\x00\x01IM", 4);
  return {text.begin(), text.end()};
}

/// The bytes of a variable before its numbers.
Bytes matrix_header(const std::string& name, std::uint32_t array_class, std::uint32_t rows,
                    std::uint32_t columns, std::uint32_t type, std::uint64_t data_bytes) {
  Bytes body;
  for (const std::uint32_t word : {std::uint32_t{kUint32}, 8U, array_class, 0U}) body.put(word);
  for (const std::uint32_t word : {std::uint32_t{kInt32}, 8U, rows, columns}) body.put(word);
  body.put(kInt8);
  body.put(static_cast<std::uint32_t>(name.size()));
  body.put(name.data(), name.size());
  body.pad();
  body.put(type);
  body.put(static_cast<std::uint32_t>(data_bytes));
  Bytes whole;
  whole.put(kMatrix);
  whole.put(static_cast<std::uint32_t>(body.all().size() + padded(data_bytes)));
  whole.put(body.all().data(), body.all().size());
  return whole;
}

/// A name that MATLAB allows and that no other variable has: letters, digits and _, at most 63.
std::string variable(const std::string& name, std::set<std::string>& taken) {
  constexpr std::size_t kLongest = 63;
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  std::string valid;
  for (const char c : name) valid += letter(c) || (c >= '0' && c <= '9') ? c : '_';
  if (valid.empty() || !letter(valid.front())) valid.insert(0, "x");
  valid.resize(std::min(valid.size(), kLongest));
  std::string unique = valid;
  for (int n = 2; !taken.insert(unique).second; ++n) {
    const std::string suffix = "_" + std::to_string(n);
    unique = valid.substr(0, kLongest - suffix.size()) + suffix;
  }
  return unique;
}

class MatWriter final : public ExportWriter {
 public:
  MatWriter(const std::filesystem::path& file, const ExportTable& table)
      : table_(table), file_(File::create(file)) {
    append(file_header());
    std::set<std::string> taken{"description"};
    append_text("description", description_json(table));
    for (const auto& group : table.group) {
      check_size(group);
      std::vector<std::uint64_t> places{append_column(variable(group.name + "_time_s", taken), group.rows)};
      for (const auto& channel : group.channel)
        places.push_back(append_column(variable(channel.name, taken), group.rows));
      place_.push_back(std::move(places));
    }
  }

  void add(std::size_t group, const ExportRows& rows) override {
    const auto& channels = table_.group[group].channel;
    numbers_.resize(rows.rows());
    for (std::size_t row = 0; row < rows.rows(); ++row)
      numbers_[row] = static_cast<double>(rows.time_ns[row]) * 1e-9;
    write(place_[group][0], rows.first_row);
    for (std::size_t c = 0; c < channels.size(); ++c) {
      for (std::size_t row = 0; row < rows.rows(); ++row) {
        const std::int32_t counts = rows.counts[row * channels.size() + c];
        numbers_[row] =
            counts == kMissingCounts ? std::numeric_limits<double>::quiet_NaN() : channels[c].value(counts);
      }
      write(place_[group][c + 1], rows.first_row);
    }
  }

  void close() override { file_.close(); }

 private:
  static void check_size(const ExportGroup& group) {
    constexpr std::uint64_t kAround = 256;  // a variable's header
    if (static_cast<std::uint64_t>(group.rows) * sizeof(double) + kAround > kMostVariableBytes)
      throw ConfigError(
          "mat: " + std::to_string(group.rows) + " samples of " + group.name +
          " are more than a variable of 2 GB holds; allowed: 268435000 (--from, --to), or hdf5");
  }

  void append(std::span<const std::uint8_t> bytes) {
    file_.write_all_at(end_, bytes);
    end_ += bytes.size();
  }

  /// @return where its numbers go
  std::uint64_t append_column(const std::string& name, std::int64_t rows) {
    const auto bytes = static_cast<std::uint64_t>(rows) * sizeof(double);
    append(matrix_header(name, kDoubles, static_cast<std::uint32_t>(rows), 1, kDouble, bytes).all());
    const std::uint64_t place = end_;
    end_ += bytes;
    return place;
  }

  /// @param text  ASCII
  void append_text(const std::string& name, const std::string& text) {
    Bytes whole = matrix_header(name, kCharacters, 1, static_cast<std::uint32_t>(text.size()), kUint16,
                                2 * text.size());
    for (const char c : text) {
      const auto unit = static_cast<std::uint16_t>(static_cast<unsigned char>(c));
      whole.put(&unit, sizeof unit);
    }
    whole.pad();
    append(whole.all());
  }

  void write(std::uint64_t place, std::int64_t first_row) {
    file_.write_all_at(
        place + static_cast<std::uint64_t>(first_row) * sizeof(double),
        {reinterpret_cast<const std::uint8_t*>(numbers_.data()), numbers_.size() * sizeof(double)});
  }

  const ExportTable table_;
  File file_;
  std::uint64_t end_ = 0;
  std::vector<std::vector<std::uint64_t>> place_;  ///< [group][0: time, then channels] of the first number
  std::vector<double> numbers_;
};

}  // namespace

std::unique_ptr<ExportWriter> make_mat_writer(const std::filesystem::path& file, const ExportTable& table) {
  return std::make_unique<MatWriter>(file, table);
}

}  // namespace roadbalance
