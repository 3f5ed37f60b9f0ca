#include "host/recording/manifest.hpp"

#include <nlohmann/json.hpp>

#include "common/record/file.hpp"
#include "common/record/folder.hpp"
#include "common/record/segment.hpp"
#include "host/recording/preamble.hpp"

namespace roadbalance {
namespace {

std::filesystem::path manifest_path(const std::filesystem::path& folder) {
  return folder / "manifest.json";
}

nlohmann::json manifest_in(const std::filesystem::path& folder, Disk& disk) {
  return nlohmann::json::parse(read_text(manifest_path(folder), disk).value_or(""), nullptr, false);
}

bool lists_segments(const nlohmann::json& manifest) {
  return manifest.is_object() && manifest.contains("segments") && manifest["segments"].is_array();
}

}  // namespace

void write_manifest(const std::filesystem::path& folder, std::optional<int> last, Disk& disk,
                    const std::set<int>& without) {
  auto sizes = read_manifest(folder, disk);
  for (const int number : segment_numbers(folder, disk)) {
    const auto path = segment_path(folder, number);
    if (!last || number <= *last) sizes.emplace(path.filename().string(), size_of_file(path, disk));
  }
  for (const int number : without) sizes.erase(segment_path(folder, number).filename().string());
  nlohmann::json segments = nlohmann::json::array();
  for (const auto& [file, bytes] : sizes) segments.push_back({{"file", file}, {"bytes", bytes}});
  const nlohmann::json manifest = {
      {"format", kRecordFormat}, {"format_version", kRecordFormatVersion}, {"segments", segments}};
  write_atomically(manifest_path(folder), manifest.dump(2) + "\n", disk);
}

FinishedSegments read_manifest(const std::filesystem::path& folder, Disk& disk) {
  std::map<std::string, std::uint64_t> sizes;
  const auto manifest = manifest_in(folder, disk);
  if (!lists_segments(manifest)) return sizes;
  for (const auto& entry : manifest["segments"]) {
    if (!entry.is_object() || !entry.contains("file") || !entry.contains("bytes")) continue;
    const auto& file = entry["file"];
    const auto& bytes = entry["bytes"];
    if (file.is_string() && bytes.is_number_unsigned())
      sizes.emplace(file.get<std::string>(), bytes.get<std::uint64_t>());
  }
  return sizes;
}

bool is_manifest_damaged(const std::filesystem::path& folder, Disk& disk) {
  return path_exists(manifest_path(folder), disk) && !lists_segments(manifest_in(folder, disk));
}

bool is_torn_tail(const RecordReader::Damage& damage, const FinishedSegments& finished) {
  return damage.torn && !finished.contains(damage.segment.filename().string());
}

std::uint64_t damaged_bytes(const std::filesystem::path& folder, const RecordReader& reader) {
  const FinishedSegments finished = read_manifest(folder, rescue_disk());
  std::uint64_t bytes = 0;
  for (const auto& damage : reader.damage())
    if (!is_torn_tail(damage, finished)) bytes += damage.bytes;
  return bytes;
}

}  // namespace roadbalance
