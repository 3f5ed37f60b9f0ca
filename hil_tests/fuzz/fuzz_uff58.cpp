#include "hil_tests/fuzz/memory_file.hpp"
#include "hil_tests/fuzz/sample_check.hpp"
#include "host/recording/formats/uff58_reader.hpp"

// Import of universal files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const fuzz::MemoryFile file({reinterpret_cast<const char*>(data), size});
  fuzz::check_samples(file.path(), open_uff58_samples);
  return 0;
}
