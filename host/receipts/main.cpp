#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "common/bus/bus.hpp"
#include "common/process/channel.hpp"
#include "common/process/parallel.hpp"
#include "common/process/pause.hpp"
#include "common/process/stop_on_signal.hpp"
#include "host/receipts/receipt.hpp"
#include "host/receipts/recordings_list.hpp"

namespace {

using namespace roadbalance;

/// Process: folders -> receipts, one after the other.  Ends when its input closes.
void check(In<std::filesystem::path> folders, Out<RecordingReceipt> receipts) {
  while (const auto folder = folders.receive())
    if (!receipts.send(receipt_of(*folder))) return;
}

/// Process: the folder -> the list on the bus, once a second.
void tell(std::stop_token stop, const std::string& url, RecordingsList list,
          Out<std::filesystem::path> folders, In<RecordingReceipt> receipts) {
  Bus bus(url);
  bool waiting = false;
  do {
    if (auto receipt = receipts.receive_for(std::chrono::seconds(0))) {
      list.take(std::move(*receipt));
      waiting = false;
    }
    try {
      list.look(std::filesystem::file_time_type::clock::now());
    } catch (const std::filesystem::filesystem_error& error) {
      std::fprintf(stderr, "rb-recordings: %s\n", error.what());  // somebody moves what is listed: once more
    }
    if (const auto next = waiting ? std::nullopt : list.unread_one()) waiting = folders.try_send(*next);
    for (const RecordingReceipt& receipt : list.told()) bus.publish(kRecordingChannel, encode(receipt));
  } while (pause(stop, std::chrono::seconds(1)));
}

}  // namespace

int main(int argc, char** argv) {
  const StopOnSignal signals;
  std::string url = default_bus_url(), folder;
  CLI::App app("Tells on the bus which recordings there are, and what proves that they are whole.");
  app.add_option("--url", url, "LCM address of the bus")->capture_default_str();
  app.add_option("--folder", folder, "that holds the folders of recordings")
      ->required()
      ->check(CLI::ExistingDirectory);
  try {
    app.parse(argc, argv);
    // Whatever else this computer does is more urgent: it records.
    setpriority(PRIO_PROCESS, 0, 19);
    auto [folders_out, folders_in] = make_channel<std::filesystem::path>(1);
    auto [receipts_out, receipts_in] = make_channel<RecordingReceipt>(1);
    Parallel processes;
    const std::stop_callback pass_on(signals.token(), [&] { processes.request_stop(); });
    processes.run(check, std::move(folders_in), std::move(receipts_out));
    processes.run(tell, url, RecordingsList(folder), std::move(folders_out), std::move(receipts_in));
    processes.wait();
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "rb-recordings: %s\n", error.what());
    return 4;
  }
}
