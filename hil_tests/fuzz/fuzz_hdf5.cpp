#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/process/temporary_folder.hpp"
#include "hil_tests/fuzz/forked.hpp"
#include "hil_tests/fuzz/sample_check.hpp"
#include "host/recording/formats/hdf5_reader.hpp"

// Import of HDF5 files.  The library is as it is; the properties hold whatever it returns for a file.
namespace roadbalance {
namespace {

/// Whether the file was taken.
bool check(const std::string& file) {
  bool is_taken = false;
  try {
    is_taken = fuzz::check_samples(file, open_hdf5_samples_here);
  } catch (const std::runtime_error& error) {  // what the library refused
    fuzz::require(std::string_view(error.what()).starts_with("HDF5: " + file), "a refusal names the file");
  }
  fuzz::require(open_hdf5_objects() == 0, "nothing stays open");
  return is_taken;
}

}  // namespace
}  // namespace roadbalance

extern "C" const char* __asan_default_options() {
  return "symbolize=0";
}

extern "C" int LLVMFuzzerInitialize(int* count, char*** arguments) {
  // It asks for more memory than there is where a size is damaged, and is refused.
  static std::vector<char*> all(*arguments, *arguments + *count);
  static char limit[] = "-malloc_limit_mb=65536";
  all.insert(all.begin() + 1, limit);
  *arguments = all.data();
  *count = static_cast<int>(all.size());
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace roadbalance;
  static const TemporaryFolder work("rb-fuzz");  // the library opens nothing that has no name
  static fuzz::Forked forked("libhdf5");
  const std::string file = (work.path() / "samples.h5").string();
  std::ofstream(file, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  fuzz::require(std::filesystem::file_size(file) == size, "there is room for a file");
  forked.run([&] { return check(file); });
  return 0;
}
