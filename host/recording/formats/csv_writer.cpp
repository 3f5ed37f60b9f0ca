#include "host/recording/formats/csv_writer.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "host/recording/formats/byte_sink.hpp"
#include "host/recording/formats/csv_text.hpp"
#include "host/recording/formats/decimal_text.hpp"
#include "host/recording/formats/only_group.hpp"

namespace roadbalance {
namespace {

constexpr int kTimeDecimals = 9;

class CsvWriter final : public ExportWriter {
 public:
  CsvWriter(const std::filesystem::path& file, const ExportGroup& group) : sink_(file) {
    std::string names = "time_s", units = "s";
    for (const ExportChannel& channel : group.channel) {
      names += "," + name_cell(channel.name);
      units += "," + quoted_if_needed(channel.unit);
      const int decimals = decimals_of(channel.scale);
      column_.push_back({channel.scale, channel.offset_counts, std::pow(10.0, decimals), decimals});
    }
    sink_.put(names + "\n" + units + "\n");
    line_.resize((column_.size() + 1) * (kDecimalText + 1) + 1);
  }

  void add(std::size_t, const ExportRows& rows) override {
    const std::int32_t* counts = rows.counts.data();
    for (const std::int64_t time_ns : rows.time_ns) {
      char* to = write_decimal(line_.data(), time_ns, kTimeDecimals);
      for (const Column& column : column_) {
        *to++ = ',';
        const std::int32_t raw = *counts++;
        if (raw == kMissingCounts) continue;
        to = write_decimal(to, (static_cast<double>(raw) - column.offset_counts) * column.scale, column.power,
                           column.decimals);
      }
      *to++ = '\n';
      sink_.put(std::string_view(line_.data(), static_cast<std::size_t>(to - line_.data())));
    }
  }

  void close() override { sink_.close(); }

 private:
  struct Column {
    double scale, offset_counts, power;
    int decimals;
  };
  ByteSink sink_;
  std::vector<Column> column_;
  std::vector<char> line_;
};

}  // namespace

std::unique_ptr<ExportWriter> make_csv_writer(const std::filesystem::path& file, const ExportTable& table) {
  return std::make_unique<CsvWriter>(file, only_group(table, "csv"));
}

}  // namespace roadbalance
