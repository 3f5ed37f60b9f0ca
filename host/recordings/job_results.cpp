#include "host/recordings/job_results.hpp"

#include <stdexcept>
#include <system_error>

#include "common/text/format.hpp"

namespace roadbalance {
namespace {

namespace fs = std::filesystem;

fs::path half_of(const fs::path& result) {
  return result.string() + ".part";
}

bool is_there(const fs::path& path) {
  return fs::symlink_status(path).type() != fs::file_type::not_found;
}

std::uintmax_t bytes_of(const fs::path& path) {
  std::error_code error;
  if (fs::is_regular_file(path, error)) return fs::file_size(path, error);
  std::uintmax_t bytes = 0;
  for (const auto& file : fs::directory_iterator(path, error)) {
    const auto size = file.is_regular_file(error) ? file.file_size(error) : 0;
    if (!error) bytes += size;
  }
  return bytes;
}

}  // namespace

fs::path free_place(const fs::path& folder, const ResultName& name,
                    const std::function<bool(const std::string&)>& is_taken) {
  constexpr std::size_t kMostName = 95;  // as common/wire/recording_t holds it
  constexpr int kMostNumber = 9999;
  for (int number = 1; number <= kMostNumber; ++number) {
    const std::string numbered =
        name.stem + (number == 1 ? "" : "-" + std::to_string(number)) + name.extension;
    if (numbered.size() > kMostName)
      throw std::runtime_error("its name would be too long: " + numbered +
                               "; give the recording a shorter one");
    const fs::path place = folder / numbered;
    if (!is_taken(numbered) && !is_there(place) && !is_there(half_of(place))) return place;
  }
  throw std::runtime_error((folder / (name.stem + name.extension)).string() +
                           ": all its numbers are taken; give the recording another name");
}

void discard_half(const fs::path& result) {
  std::error_code ignored;
  fs::remove_all(half_of(result), ignored);
}

std::string words_of(const fs::path& result) {
  return format("%s, %.1f MB", result.c_str(), 1e-6 * static_cast<double>(bytes_of(result)));
}

}  // namespace roadbalance
