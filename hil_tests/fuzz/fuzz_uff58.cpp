#include <cmath>
#include <set>
#include <string>
#include <string_view>

#include "common/config/section.hpp"
#include "hil_tests/fuzz/memory_file.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/exchange/uff58_reader.hpp"

// Import of universal files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  using fuzz::require;
  const fuzz::MemoryFile file({reinterpret_cast<const char*>(data), size});
  try {
    const SampleTable table = read_uff58_samples(file.path());
    require(!table.name.empty() && table.name.size() == table.value_si.size(), "every channel has values");
    require(std::set(table.name.begin(), table.name.end()).size() == table.name.size(),
            "no name stands twice");
    for (const auto& column : table.value_si) {
      require(column.size() == table.time_s.size(), "every row has every channel");
      for (const double value : column) require(!std::isinf(value), "a sample is a number, or not there");
    }
    for (std::size_t row = 1; row < table.time_s.size(); ++row)
      require(table.time_s[row - 1] <= table.time_s[row], "time never falls");
  } catch (const ConfigError& error) {
    require(std::string_view(error.what()).starts_with(file.path() + ":"),
            "an error names the file and the line");
  }
  return 0;
}
