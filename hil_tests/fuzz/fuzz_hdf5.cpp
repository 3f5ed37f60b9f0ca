#include <stdexcept>

#include "hil_tests/fuzz/memory_file.hpp"
#include "hil_tests/fuzz/sample_check.hpp"
#include "host/exchange/hdf5_reader.hpp"

// Import of HDF5 files.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  const fuzz::MemoryFile file({reinterpret_cast<const char*>(data), size});
  try {
    fuzz::check_samples(file.path(), open_hdf5_samples);
  } catch (const std::runtime_error& error) {  // what the library refused
    fuzz::require(std::string_view(error.what()).starts_with("HDF5: "), "a refusal says whose it is");
  }
  return 0;
}
