#include "tools/views/recording_defects.hpp"

#include <cstdio>

#include "common/text/printable.hpp"

namespace roadbalance {

void warn_of_defects(const std::string& command, const std::string& folder, const RecordingDefects& defects) {
  if (!defects.any()) return;
  std::fprintf(
      stderr,
      "rb %s: %s is damaged: %llu bytes unreadable, %lld blocks refused, %lld missing; the result is from "
      "the rest. rb verify lists them\n",
      command.c_str(), printable_text(folder).c_str(), static_cast<unsigned long long>(defects.damaged_bytes),
      static_cast<long long>(defects.refused_blocks), static_cast<long long>(defects.missing_blocks));
}

}  // namespace roadbalance
