#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/section.hpp"
#include "hil_tests/fuzz/property.hpp"
#include "host/recording/formats/sample_source.hpp"

namespace roadbalance::fuzz {

/// All rows of a pass behind each other, checked.
inline std::vector<double> pass_of(SampleSource& source) {
  std::vector<double> all;
  double before_s = -std::numeric_limits<double>::infinity();
  for (SampleRows rows; source.read(rows);) {
    require(rows.rows() > 0 && rows.rows() <= SampleSource::kRowsAtOnce,
            "a read gives some rows, not too many");
    require(rows.channels == source.channels().size() && rows.value.size() == rows.rows() * rows.channels,
            "every row has every channel");
    for (const double time_s : rows.time_s) {
      require(is_countable(time_s) && time_s >= before_s, "time can be counted and never falls");
      before_s = time_s;
    }
    for (const double value : rows.value) require(!std::isinf(value), "a sample is a number, or not there");
    require(source.part() >= 0.0 && source.part() <= 1.0, "progress is a share");
    all.insert(all.end(), rows.time_s.begin(), rows.time_s.end());
    all.insert(all.end(), rows.value.begin(), rows.value.end());
  }
  return all;
}

/// Properties of a file of samples, however it was opened: refused naming it or `other`, or rows that are the
/// same each time.
/// @return whether it gave rows
template <typename Open>
bool check_samples(const std::string& path, Open open, const std::string& other = "") {
  static Reached rows("rows");
  try {
    const auto source = open(path);
    const auto& channels = source->channels();
    require(!channels.empty(), "there are channels");
    std::set<std::string> names;
    for (const FileChannel& channel : channels) names.insert(channel.name);
    require(names.size() == channels.size(), "no name stands twice");
    const std::vector<double> first = pass_of(*source);
    source->rewind();
    const std::vector<double> again = pass_of(*source);
    // A missing sample is NaN, which is not equal to itself.
    const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
    require(std::ranges::equal(first, again, same), "another pass gives the same");
    if (!first.empty()) rows.count();
    return !first.empty();
  } catch (const ConfigError& error) {
    const std::string_view said(error.what());
    require(said.starts_with(path) || (!other.empty() && said.starts_with(other)), "an error names the file");
    return false;
  }
}

}  // namespace roadbalance::fuzz
