#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "common/bus/bus.hpp"
#include "common/bus/job.hpp"
#include "common/bus/operation.hpp"
#include "common/command_line/bus_url.hpp"
#include "common/command_line/manual.hpp"
#include "common/command_line/run_program.hpp"
#include "common/process/channel.hpp"
#include "common/process/child.hpp"
#include "common/process/parallel.hpp"
#include "common/process/stop_on_signal.hpp"
#include "common/record/failure_words.hpp"
#include "common/record/file.hpp"
#include "common/types/clocks.hpp"
#include "host/recordings/jobs.hpp"
#include "host/recordings/recording_summary.hpp"
#include "host/recordings/recordings_list.hpp"

namespace {

using namespace roadbalance;

/// Process: folders -> summaries, one after the other.  Ends when its input closes.
void check(In<std::filesystem::path> folders, Out<RecordingSummary> summaries) {
  while (const auto folder = folders.receive())
    if (!summaries.send(summary_of(*folder))) return;
}

using std::chrono::milliseconds;
constexpr milliseconds kTurn{50};
constexpr milliseconds kSendInterval{1000};

/// The list and its jobs on the bus.
class ListOnBus {
 public:
  ListOnBus(const std::string& url, const std::filesystem::path& folder, const JobPlaces& places,
            Out<std::filesystem::path> folders, In<RecordingSummary> summaries)
      : bus_(url),
        list_(folder, places.results),
        jobs_(sibling_program("rb"), places),
        folders_(std::move(folders)),
        summaries_(std::move(summaries)) {
    bus_.subscribe(kRequestChannel, [this](std::string_view, auto bytes) {
      const auto request = decode_request(bytes);
      if (!request) return;
      if (const auto answer = jobs_.take(*request, list_.listed(), list_.grows(), JobInstant::now()))
        (void)bus_.publish(kAnswerChannel, encode(*answer));
    });
    look();
  }

  void turn() {
    bus_.handle(kTurn);
    jobs_.turn(list_.grows(), JobInstant::now());
    if (WallClock::now() - sent_at_ < kSendInterval) return;
    sent_at_ = WallClock::now();
    look();
    publish_list();
  }

 private:
  void look() {
    if (auto summary = summaries_.receive_for(std::chrono::seconds(0))) {
      list_.take(std::move(*summary));
      waiting_ = false;
    }
    try {
      list_.look(std::filesystem::file_time_type::clock::now());
    } catch (const std::filesystem::filesystem_error& error) {
      std::fprintf(stderr, "rb-recordings: %s\n",
                   failure_words(error).c_str());  // a folder was moved meanwhile: the next look finds it
    }
    if (const auto next = waiting_ ? std::nullopt : list_.unread_one()) waiting_ = folders_.try_send(*next);
  }

  void publish_list() {
    for (const RecordingSummary& summary : list_.reported())
      (void)bus_.publish(kRecordingChannel, encode(summary));
    for (const Job& job : jobs_.reported()) (void)bus_.publish(kJobChannel, encode(job));
    for (const DocumentPart& part : jobs_.due_parts()) (void)bus_.publish(kDocumentChannel, encode(part));
  }

  Bus bus_;
  RecordingsList list_;
  Jobs jobs_;
  Out<std::filesystem::path> folders_;
  In<RecordingSummary> summaries_;
  bool waiting_ = false;
  WallTime sent_at_{};
};

/// Process: the folder -> the list on the bus, once a second; requests -> jobs.
void publish_list(std::stop_token stop, const std::string& url, const std::filesystem::path& folder,
                  const JobPlaces& places, Out<std::filesystem::path> folders,
                  In<RecordingSummary> summaries) {
  ListOnBus list(url, folder, places, std::move(folders), std::move(summaries));
  while (!stop.stop_requested()) list.turn();
}

/// The absolute path of a folder, without a slash at its end.
std::filesystem::path whole(const std::string& folder) {
  const auto path = std::filesystem::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();
}

/// Results lie beside the recordings and not among them, where their folder would be taken for one.
JobPlaces places_of(const std::string& folder, const std::string& results, const std::string& transfer_to) {
  JobPlaces places{.results = results.empty() ? whole(folder).string() + "-results" : whole(results).string(),
                   .transfer_to = transfer_to.empty() ? std::filesystem::path{} : whole(transfer_to)};
  if (places.results == whole(folder))
    throw std::runtime_error("--results " + results + ": is the folder of the recordings; allowed: another");
  if (places.transfer_to == whole(folder) || places.transfer_to == places.results)
    throw std::runtime_error("--transfer-to " + transfer_to +
                             ": is the folder of the recordings, or of the results; allowed: another");
  return places;
}

/// Locks the folder of results: two programs would share one book of jobs, and each would remove the other's
/// unfinished results.  Nothing if the folder cannot be made: then no job makes anything there.
std::optional<File> hold(const std::filesystem::path& results) {
  std::error_code error;
  std::filesystem::create_directories(results, error);
  if (error) return std::nullopt;
  File folder = File::open_folder(results);
  if (!folder.try_lock())
    throw std::runtime_error("--results " + results.string() + ": another rb-recordings works there");
  return folder;
}

/// Lowest priority: anything else on this computer is more urgent, above all recording.  Jobs inherit it.
void yield_to_all() {
  setpriority(PRIO_PROCESS, 0, 19);
  constexpr int kOfThread = 1, kIdleClass = 3 << 13;  // ioprio_set(2)
  syscall(SYS_ioprio_set, kOfThread, 0, kIdleClass);
}

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  std::string url, folder, results, transfer_to;
  CLI::App app(
      "Tells on the bus which recordings there are and what proves that they are whole, and does with them "
      "what the page asks.",
      "rb-recordings");
  add_bus_url(app, url);
  app.add_option("--folder", folder, "that holds the folders of recordings")->required();
  app.add_option("--results", results,
                 "folder for what jobs make: recordings, exports; if not given, that of the recordings with "
                 "-results behind its name");
  app.add_option("--transfer-to", transfer_to,
                 "folder that the page may have recordings copied to; if not given, it may not");
  add_version(app);
  add_manual(app);
  try {
    app.parse(argc, argv);
    if (!std::filesystem::is_directory(folder))
      throw std::runtime_error("--folder " + folder + ": there is no such folder");
    const JobPlaces places = places_of(folder, results, transfer_to);
    const auto held = hold(places.results);
    yield_to_all();
    auto [folders_out, folders_in] = make_channel<std::filesystem::path>(1);
    auto [summaries_out, summaries_in] = make_channel<RecordingSummary>(1);
    Parallel processes;
    const std::stop_callback pass_on(signals.token(), [&] { processes.request_stop(); });
    processes.run(check, std::move(folders_in), std::move(summaries_out));
    processes.run(publish_list, url, whole(folder), places, std::move(folders_out), std::move(summaries_in));
    processes.wait();
    return 0;
  } catch (const CLI::ParseError& error) {
    return report_failure(app, error);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-recordings: %s\n", failure_words(error).c_str());
    return 4;
  }
}
