#include "host/recorder/recorder.hpp"

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "common/clock/utc.hpp"
#include "common/link/receiver.hpp"
#include "common/process/heap.hpp"
#include "common/process/parallel.hpp"
#include "common/process/pause.hpp"
#include "common/record/folder.hpp"
#include "host/recorder/clock_asker.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recorder/power/power_line.hpp"
#include "host/recorder/power/sleep_inhibitor.hpp"
#include "host/recorder/receive.hpp"
#include "host/recorder/recording_store.hpp"
#include "host/recorder/write.hpp"
#include "host/recording/continued_folders.hpp"

namespace roadbalance {
namespace {

// Credit bounds what is under way to a few thousand blocks a node, so these are never full.
constexpr std::size_t kBatches = 65'536;
constexpr std::size_t kNews = 64;
constexpr std::size_t kEvents = 1024;
constexpr std::size_t kClockPeers = 1024;  // heartbeats: ten a second from each node

// A supply that was never read was named by mistake; but one that goes away while a recording is under way
// must not keep a recorder that is started again from going on with it.
std::unique_ptr<PowerLine> open_power(const RecorderOptions& options) {
  if (options.power.empty()) return nullptr;
  auto power = open_power_line(options.power);
  const bool continues = path_exists(options.folder / kIncarnationFile);
  if (!continues && !power->is_good())
    throw std::runtime_error("power line " + options.power +
                             " cannot be read: is the name right, and may this user read it?");
  return power;
}

// An answer that takes its time is not waited for.
void stay_awake(std::stop_token stop, const RecorderOptions& options) {
  const SleepInhibitor inhibitor;
  if (!inhibitor.refusal().empty() && options.on_warning)
    options.on_warning("this computer may fall asleep while it records: " + inhibitor.refusal());
  while (pause(stop, std::chrono::hours(1))) {
  }
}

// By their names, for neither need be there yet, or can be asked.
void refuse_one_folder_twice(const RecorderOptions& options) {
  if (options.fallback.empty()) return;
  const auto real_name = [](const std::filesystem::path& folder) {
    std::error_code refused;
    auto name = std::filesystem::weakly_canonical(std::filesystem::absolute(folder), refused);
    if (refused) name = full_name(folder);
    return name.has_filename() ? name : name.parent_path();
  };
  if (real_name(options.folder) == real_name(options.fallback))
    throw std::invalid_argument("fallback folder " + options.fallback.string() +
                                ": is the first folder itself; name one on another disk");
}

}  // namespace

StoreOptions RecorderOptions::store() const {
  return {.folder = folder,
          .fallback = fallback,
          .continues = continues,
          .segment_bytes = segment_bytes,
          .commit_period = commit_period,
          .reserve_bytes = reserve_bytes,
          .ballast_bytes = reserve_bytes / 4,
          .first_at_once = first_at_once,
          .notes_clocks = sends_state,
          .keep_bytes = keep_bytes};
}

void reserve_heap_for(std::size_t nodes) {
  // Blocks out of order, and those that wait for the disk, which take up to three times their size while the
  // memory that holds them grows.
  constexpr auto kOfANode =
      static_cast<std::size_t>(ReceiverOptions{}.window + 3 * ReceiverOptions{}.undurable) * sizeof(Delivery);
  static std::atomic<std::size_t> provided_for = 0;  // the heap keeps what it once had
  if (provided_for.exchange(std::max(nodes, provided_for.load())) < nodes) reserve_heap(nodes * kOfANode);
}

void refuse_mistakes(const RecorderOptions& options) {
  refuse_one_folder_twice(options);
  if (!options.power.empty()) open_power_line(options.power);  // which reads nothing yet
}

RecorderReport run_recorder(std::stop_token stop, const RecorderOptions& options) {
  refuse_mistakes(options);
  const auto power = open_power(options);
  StoreOptions how = options.store();
  how.least_incarnation = std::max(utc_us() / 1000, options.first_incarnation);
  RecordingStore store(kernel_disk(), std::move(how));
  if (options.on_cut_tail)
    for (const RecordWriter::CutTail& tail : store.cut_tails()) options.on_cut_tail(tail);
  const Incarnation incarnation{.number = store.incarnation(), .folder = store.folder()};

  auto [batches_out, batches_in] = make_channel<WriteBatch>(kBatches);
  auto [news_out, news_in] = make_channel<WriterNews>(kNews);
  auto [events_out, events_in] = make_channel<RecordEvent>(kEvents);
  auto [peers_out, peers_in] = make_channel<ClockPeer>(kClockPeers);
  const WriteOptions write_options{
      .power = power.get(), .on_warning = options.on_warning, .notes = options.notes};
  RecorderReport report;

  std::jthread awake;
  if (options.keeps_awake) awake = std::jthread(stay_awake, std::cref(options));
  Parallel recorder;
  const std::stop_callback pass_on(stop, [&recorder] { recorder.request_stop(); });
  recorder.run(write_record, std::ref(store), std::cref(write_options), std::move(batches_in),
               std::move(events_in), std::move(news_out));
  recorder.run(ask_clocks, options.url, std::move(peers_in), std::move(events_out));
  recorder.run(receive, std::cref(options), std::cref(incarnation), std::cref(store.recovered()),
               std::move(batches_out), std::move(news_in), std::move(peers_out), std::ref(report));
  recorder.wait();
  report.marks = store.durable_marks();
  return report;
}

}  // namespace roadbalance
