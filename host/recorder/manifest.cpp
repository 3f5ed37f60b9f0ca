#include "host/recorder/manifest.hpp"

#include <nlohmann/json.hpp>

#include "common/record/file.hpp"
#include "common/record/segment.hpp"

namespace roadbalance {

void write_manifest(const std::filesystem::path& folder) {
  nlohmann::json segments = nlohmann::json::array();
  for (const int number : segment_numbers(folder)) {
    const auto path = segment_path(folder, number);
    segments.push_back({{"file", path.filename().string()}, {"bytes", std::filesystem::file_size(path)}});
  }
  const nlohmann::json manifest = {
      {"format", "roadbalance record"}, {"format_version", 1}, {"segments", segments}};
  write_atomically(folder / "manifest.json", manifest.dump(2) + "\n");
}

}  // namespace roadbalance
