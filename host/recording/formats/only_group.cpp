#include "host/recording/formats/only_group.hpp"

#include <string>

#include "common/config/section.hpp"

namespace roadbalance {

const ExportGroup& only_group(const ExportTable& table, const char* format) {
  if (table.group.size() == 1) return table.group.front();
  std::string names;
  for (const auto& group : table.group) names += " " + group.name;
  throw ConfigError(std::string(format) + ": has room for samples of one clock, and this recording has" +
                    names + "; allowed: one node at a time (--channels NODE), or another format");
}

}  // namespace roadbalance
