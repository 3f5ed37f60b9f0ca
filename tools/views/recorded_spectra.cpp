#include "tools/views/recorded_spectra.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/config/section.hpp"

namespace roadbalance {

ChannelPlace find_channel(const VehicleConfig& vehicle, const std::string& option, const std::string& name) {
  std::string there;
  for (std::size_t n = 0; n < vehicle.node.size(); ++n)
    for (std::size_t c = 0; c < vehicle.node[n].channel.size(); ++c) {
      if (vehicle.node[n].channel[c].name == name) return {static_cast<int>(n), static_cast<int>(c)};
      there += " " + vehicle.node[n].channel[c].name;
    }
  throw ConfigError(option + " " + name + ": the recording has no such channel; allowed:" + there);
}

int segment_samples(double segment_s, double rate_hz) {
  return std::max(2, static_cast<int>(std::lround(segment_s * rate_hz)));
}

const std::map<std::string, Window>& windows_by_name() {
  static const std::map<std::string, Window> windows{
      {"hann", Window::kHann}, {"flat-top", Window::kFlatTop}, {"rectangular", Window::kRectangular}};
  return windows;
}

void say_no_segment(const char* command, const JointSpectra& spectra) {
  const std::string why = spectra.refusal();
  std::fprintf(stderr, "rb %s: %s\n", command,
               why.empty() ? "no stretch without a hole is as long as a segment" : why.c_str());
}

}  // namespace roadbalance
