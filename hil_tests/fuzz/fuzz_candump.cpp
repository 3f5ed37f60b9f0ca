#include <string_view>

#include "hil_tests/fuzz/memory_file.hpp"
#include "hil_tests/fuzz/sample_check.hpp"
#include "tools/import/candump_samples.hpp"

// Import of candump logs: a DBC file, a byte 0, the log.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto border = text.find('\0');
  if (border == std::string_view::npos) return 0;
  const fuzz::MemoryFile dbc(text.substr(0, border)), log(text.substr(border + 1));
  fuzz::check_samples(
      log.path(), [&](const std::string& path) { return open_candump_samples(path, dbc.path()); },
      dbc.path());
  return 0;
}
