#include "tools/rb/identify_many.hpp"

#include <numeric>

#include "common/process/in_order.hpp"
#include "host/analyser/recordings_given.hpp"
#include "tools/rb/progress_line.hpp"

namespace roadbalance {

namespace fs = std::filesystem;

void share_on_threads(const std::vector<fs::path>& recordings, const ShareWork& work,
                      const std::function<void(std::size_t which, DriveShare share)>& take) {
  std::vector<std::size_t> which(recordings.size());
  std::iota(which.begin(), which.end(), std::size_t{0});
  in_order<DriveShare>(
      which, work.jobs, work.stop,
      [&](std::size_t i, const std::stop_token& stop) { return share_of(recordings[i], work.refine, stop); },
      take);
}

TogetherTold identify_together(const std::vector<fs::path>& recordings, bool skip_unusable,
                               const ShareWork& work, const DriveSharer& sharer) {
  ManyRecordings many(recordings, skip_unusable);
  std::vector<std::uint64_t> bytes;
  for (const fs::path& recording : many.recordings()) bytes.push_back(bytes_of_recording(recording));
  const auto all = static_cast<double>(std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0}));
  {
    ProgressLine line;
    std::uint64_t done = 0;
    sharer(many.recordings(), work, [&](std::size_t which, DriveShare share) {
      many.take(many.recordings()[which], std::move(share));
      done += bytes[which];
      line.show(all > 0.0 ? static_cast<double>(done) / all : 1.0, done);
    });
  }
  RecordedEstimate found = many.conclude();
  return {std::move(found), many.used(), many.left_out()};
}

nlohmann::ordered_json recordings_json(const TogetherTold& told) {
  auto used = nlohmann::ordered_json::array(), left_out = nlohmann::ordered_json::array();
  for (const ManyRecordings::Used& one : told.used)
    used.push_back({{"name", one.recording.filename().string()},
                    {"seconds", one.seconds},
                    {"sections", one.sections},
                    {"missing_blocks", one.missing_blocks}});
  for (const ManyRecordings::LeftOut& one : told.left_out)
    left_out.push_back({{"name", one.recording.filename().string()}, {"why", one.why}});
  return {{"recordings", used}, {"left_out", left_out}};
}

}  // namespace roadbalance
