#include "host/exchange/marks.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "host/exchange/byte_sink.hpp"
#include "host/exchange/decimal_text.hpp"

namespace roadbalance {
namespace {

std::string in_quotes(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    // A cell is one line: what breaks one stands as a blank.
    quoted += c == '\n' || c == '\r' ? ' ' : c;
    if (c == '"') quoted += c;
  }
  return quoted + "\"";
}

}  // namespace

void write_marks(const ExportTable& table, const std::filesystem::path& file) {
  std::vector<ExportMark> marks = table.mark;
  std::stable_sort(marks.begin(), marks.end(),
                   [](const auto& a, const auto& b) { return a.time_ns < b.time_ns; });
  ByteSink sink(file);
  sink.put("time_s,number,text\n");
  for (const ExportMark& mark : marks) {
    std::array<char, kDecimalText> text;
    const char* end = write_decimal(text.data(), mark.time_ns, 9);
    sink.put(std::string_view(text.data(), static_cast<std::size_t>(end - text.data())));
    sink.put("," + std::to_string(mark.number) + "," + in_quotes(mark.text) + "\n");
  }
  sink.close();
}

}  // namespace roadbalance
