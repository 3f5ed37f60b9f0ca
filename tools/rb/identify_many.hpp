#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <stop_token>
#include <string>
#include <vector>

#include "host/analyser/many_recordings.hpp"

namespace CLI {
class App;
}

namespace roadbalance {

/// How the shares of many recordings are made.
struct ShareWork {
  std::size_t jobs = 1;  ///< recordings at a time, in a process
  bool refine = false;
  std::stop_token stop;
};

/// Makes the share of each recording and gives them to `take` in order: on the cores of this machine, or over
/// a cluster, where another process than the first takes none.  Called once a command, with no recordings if
/// there is nothing to share out.
using DriveSharer =
    std::function<void(const std::vector<std::filesystem::path>& recordings, const ShareWork& work,
                       const std::function<void(std::size_t which, DriveShare share)>& take)>;

/// On `work.jobs` threads.
void share_on_threads(const std::vector<std::filesystem::path>& recordings, const ShareWork& work,
                      const std::function<void(std::size_t which, DriveShare share)>& take);

/// add_identify() of command.hpp with another sharer than share_on_threads().
/// @param jobs    unless --jobs says
/// @param speaks  whether this process has a result
void add_identify_over(CLI::App& app, int& code, const DriveSharer& sharer, std::size_t jobs, bool speaks);

/// What many recordings say together.
struct TogetherTold {
  RecordedEstimate found;
  std::vector<ManyRecordings::Used> used;
  std::vector<ManyRecordings::LeftOut> left_out;
};

/// @throws as ManyRecordings; Interrupted
TogetherTold identify_together(const std::vector<std::filesystem::path>& recordings, bool skip_unusable,
                               const ShareWork& work, const DriveSharer& sharer);

/// {"recordings": [{"name", "seconds", "sections", "missing_blocks"}], "left_out": [{"name", "why"}]}
nlohmann::ordered_json recordings_json(const TogetherTold& told);

}  // namespace roadbalance
