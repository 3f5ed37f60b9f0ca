#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "common/bus/notes.hpp"
#include "common/config/section.hpp"
#include "hil_tests/fuzz/memory_file.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "hil_tests/fuzz/sample_check.hpp"
#include "tools/import/csv_samples.hpp"

// CSV import: its files behind one another, parted by bytes 0: samples, pulses, marks.
namespace roadbalance {
namespace {

using fuzz::MemoryFile;
using fuzz::require;

fuzz::Reached pulses_read("pulses"), marks_read("marks");

void check_pulses(const std::string& path) {
  double before = -std::numeric_limits<double>::infinity();
  PulseSource pulses(path);
  std::int64_t first = 0, again = 0;
  for (; const auto pulse = pulses.next(); ++first) {
    require(pulse->time_s >= before, "pulses are in order of time");
    require(pulse->wheel >= 0 && pulse->wheel < kWheels, "a pulse is of one of the wheels");
    before = pulse->time_s;
  }
  pulses.rewind();
  while (pulses.next()) ++again;
  require(first == again, "another pass gives as many");
  if (first > 0) pulses_read.count();
}

void check_marks(const std::string& path) {
  double before = -std::numeric_limits<double>::infinity();
  for (const ImportedMark& mark : read_marks(path)) {
    require(mark.time_s >= before, "marks are in order of time");
    require(mark.number >= 1, "marks are numbered from 1 on");
    require(mark.text.size() <= kMaxNoteBytes, "a mark's text fits into a note");
    before = mark.time_s;
    marks_read.count();
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
  const fuzz::MemoryFile samples(next());
  fuzz::check_samples(samples.path(), open_csv_samples);
  refused_or(check_pulses, next());
  refused_or(check_marks, next());
  return 0;
}
