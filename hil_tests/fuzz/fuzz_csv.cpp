#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "common/bus/notes.hpp"
#include "common/config/section.hpp"
#include "hil_tests/fuzz/memory_file.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "tools/rb/csv_table.hpp"
#include "tools/rb/sample_clock.hpp"

// CSV import: its files behind one another, parted by bytes 0: samples, pulses, marks.
namespace roadbalance {
namespace {

using fuzz::MemoryFile;
using fuzz::require;

void check_samples(const std::string& path) {
  const SampleTable table = read_samples(path);
  require(table.name.size() == table.value_si.size(), "every channel has values");
  for (const auto& column : table.value_si) {
    require(column.size() == table.time_s.size(), "every row has every channel");
    for (const double value : column) require(!std::isinf(value), "a sample is a number, or not there");
  }
  for (std::size_t row = 1; row < table.time_s.size(); ++row)
    require(table.time_s[row - 1] <= table.time_s[row], "time never falls");
}

void check_pulses(const std::string& path) {
  double before = -std::numeric_limits<double>::infinity();
  for (const Pulse& pulse : read_pulses(path)) {
    require(pulse.time_s >= before, "pulses are in order of time");
    require(pulse.wheel >= 0 && pulse.wheel < kWheels, "a pulse is of one of the wheels");
    before = pulse.time_s;
  }
}

void check_marks(const std::string& path) {
  double before = -std::numeric_limits<double>::infinity();
  for (const ImportedMark& mark : read_marks(path)) {
    require(mark.time_s >= before, "marks are in order of time");
    require(mark.number >= 1, "marks are numbered from 1 on");
    require(mark.text.size() <= kMaxNoteBytes, "a mark's text fits into a note");
    before = mark.time_s;
  }
}

template <typename Check>
void refused_or(Check check, std::string_view text) {
  const MemoryFile file(text);
  try {
    check(file.path());
  } catch (const ConfigError& error) {
    require(std::string_view(error.what()).starts_with(file.path()), "an error names the file");
  }
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  auto next = [&, rest = std::optional(text)]() mutable {
    const auto part = rest.value_or("").substr(0, rest.value_or("").find('\0'));
    if (rest) rest = part.size() < rest->size() ? std::optional(rest->substr(part.size() + 1)) : std::nullopt;
    return part;
  };
  refused_or(check_samples, next());
  refused_or(check_pulses, next());
  refused_or(check_marks, next());
  return 0;
}
