#include "host/analysis/angle/edge_memory.hpp"

#include <cstdio>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

namespace roadbalance {

double available_memory() {
  std::ifstream file("/proc/meminfo");
  std::string key, unit;
  for (double amount = 0.0; file >> key >> amount; std::getline(file, unit))
    if (key == "MemAvailable:") return amount * 1024.0;
  return std::numeric_limits<double>::infinity();
}

void EdgeMemory::add(std::size_t edges) {
  edges_ += static_cast<double>(edges);
  if (edges_ * kBytesAnEdge <= available_) return;
  char text[200];
  std::snprintf(
      text, sizeof text,
      "it has more edges than can be held at once: the first %.0f need %.2f GB of memory, and %.2f GB are "
      "free; record shorter drives, or take a machine with more",
      edges_, 1e-9 * edges_ * kBytesAnEdge, 1e-9 * available_);
  throw std::runtime_error(text);
}

}  // namespace roadbalance
