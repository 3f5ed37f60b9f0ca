#include "tools/datum/vehicle_file.hpp"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/config/text_file.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/record/file.hpp"

namespace roadbalance {
namespace {

/// The file's text as it is, and as it will be.
std::pair<std::string, std::string> changed(const std::string& path, const std::vector<ValueToSet>& values) {
  const std::string old = read_text_file(path, Section::kMostBytes);
  std::string text = old;
  for (const ValueToSet& one : values) text = with_value(text, one.table, one.key, one.value, path);
  VehicleConfig::parse(text, path);
  return {old, text};
}

}  // namespace

void set_in_vehicle_file(const std::string& path, const std::vector<ValueToSet>& values) {
  const auto [old, text] = changed(path, values);
  // A link to a file stays one.
  const std::filesystem::path file = std::filesystem::canonical(path);
  const auto may = std::filesystem::status(file).permissions();
  const std::filesystem::path before = file.string() + ".bak";
  write_atomically(before, old);
  std::filesystem::permissions(before, may);
  write_atomically(file, text);
  std::filesystem::permissions(file, may);
}

void check_vehicle_file(const std::string& path, const std::vector<ValueToSet>& values) {
  static_cast<void>(changed(path, values));
  for (const std::string& name : {path, std::filesystem::canonical(path).parent_path().string()})
    if (access(name.c_str(), W_OK) != 0)
      throw std::system_error(errno, std::generic_category(), "write " + name);
}

}  // namespace roadbalance
