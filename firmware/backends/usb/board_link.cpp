#include "firmware/backends/usb/board_link.hpp"

#include <algorithm>
#include <cstring>
#include <future>
#include <utility>

#include "common/config/section.hpp"
#include "common/process/realtime.hpp"

namespace roadbalance {
namespace {

using board::Request;

constexpr auto kServing = std::chrono::milliseconds(100);
constexpr auto kSearching = std::chrono::milliseconds(200);
/// A running board sends ten times as often.
constexpr auto kLongestSilence = std::chrono::milliseconds(10 * board::kSilenceLimitMs);
/// A device that just came is refused by the system until its rules have been applied: no reason to complain.
constexpr auto kPatience = std::chrono::seconds(2);
constexpr int kExchanges = 8;
constexpr auto kComparing = std::chrono::milliseconds(250);
/// For a board that does not answer: each question then takes up the whole of its time limit.
constexpr auto kComparingLater = std::chrono::seconds(10);

NodeTime now() {
  return as_node_time(MachineClock::now());
}

std::uint8_t number(Request request) {
  return static_cast<std::uint8_t>(request);
}

board::Status status_of(UsbDevice& device) {
  std::array<std::uint8_t, 256> reply;
  const auto size = device.get(number(Request::kStatus), reply);
  const auto status = size ? board::decode_status(std::span(reply).first(*size)) : std::nullopt;
  if (!status) throw UsbError("the board does not give its status");
  return *status;
}

std::string refusal_of(const board::Status& status) {
  constexpr std::array kWords{"nothing",
                              "an unknown request",
                              "a wrong length",
                              "not in this state",
                              "a value it lacks",
                              "a wrong token",
                              "its hardware does not take it"};
  return kWords[std::min<std::size_t>(static_cast<std::size_t>(status.last_refusal), kWords.size() - 1)];
}

template <typename Content>
void send_request(UsbDevice& device, Request request, const char* name, const Content& content) {
  if (device.put(number(request), board::encode(content))) return;
  throw UsbError(std::string("the board refuses ") + name + ": " + refusal_of(status_of(device)));
}

/// Asks the board for its time.
BoardExchange exchange_with(UsbDevice& device) {
  BoardExchange exchange{.asked = now()};
  exchange.ticks = status_of(device).ticks;
  exchange.answered = now();
  return exchange;
}

/// The narrowest of a few: a question that follows a packet waits for the reader of that packet.
BoardExchange narrowest_exchange(UsbDevice& device) {
  BoardExchange narrowest = exchange_with(device);
  for (int k = 1; k < kExchanges; ++k)
    if (const BoardExchange other = exchange_with(device);
        other.half_round_trip() < narrowest.half_round_trip())
      narrowest = other;
  return narrowest;
}

}  // namespace

BoardLink::Session::~Session() {
  for (const auto& device : board) try {
      static_cast<void>(device->put(number(Request::kStop), {}));
    } catch (const UsbError&) {
      // It is gone, and so stopped.
    }
}

BoardLink::BoardLink(UsbAddress address, VehicleConfig vehicle, const NodeConfig& node,
                     std::vector<DeviceReport*> reports, std::function<void(const std::string&)> warn)
    : address_(std::move(address)),
      vehicle_(std::move(vehicle)),
      node_(node),
      report_(std::move(reports)),
      warn_(std::move(warn)) {
  std::promise<void> begun;
  auto outcome = begun.get_future();
  thread_ = std::jthread([this, begun = std::move(begun)](const std::stop_token& stop) mutable {
    std::unique_ptr<Session> session;
    try {
      session = begin_session(stop);
    } catch (...) {
      return begun.set_exception(std::current_exception());
    }
    begun.set_value();
    run(stop, std::move(session));
  });
  outcome.get();
}

void BoardLink::warn_about(std::size_t which, const std::string& text) const {
  warn_(address_.of_board(which) + ": " + text);
}

board::Identity BoardLink::set_up(UsbDevice& device, std::size_t which, std::uint32_t& ticks_per_scan) {
  std::array<std::uint8_t, 256> reply;
  const auto size = device.get(number(Request::kIdentify), reply);
  const auto identity = size ? board::decode_identity(std::span(reply).first(*size)) : std::nullopt;
  if (!identity) throw UsbError("this is not our board: it does not say what it is");
  if (const std::string refusal = protocol_refusal(*identity); !refusal.empty()) throw UsbError(refusal);
  const std::string note = protocol_note(*identity);
  if (!note.empty() && std::ranges::find(noted_, note) == noted_.end()) {
    noted_.push_back(note);
    warn_about(which, note);
  }
  // One that another program left running is stopped; packets that it still sends bear another token.
  if (!device.put(number(Request::kStop), {})) throw UsbError("the board does not stop");
  const BoardSetup setup = board_setup(vehicle_, node_, *identity, which, address_.boards());
  send_request(device, Request::kConfigure, "its configuration", setup.configuration);
  if (setup.configuration.references_on)
    send_request(device, Request::kReferences, "references", setup.references);
  if (which == 0 && runs_ == 1)
    for (std::size_t line = 0; line < lines_.size(); ++line)
      lines_[line] = setup.configuration.encoder[line].pulses_per_turn != 0;
  ticks_per_scan = setup.configuration.ticks_per_scan;
  return *identity;
}

std::unique_ptr<BoardLink::Session> BoardLink::begin_session(std::stop_token stop) {
  auto session = std::make_unique<Session>();
  RunBegin run;
  run.token = static_cast<std::uint32_t>(to_ns(now()) / 1000) + ++runs_;
  for (std::size_t k = 0; k < address_.boards(); ++k) try {
      const std::string serial = address_.serial.empty() ? "" : address_.serial[k];
      session->board.push_back(
          std::make_unique<UsbDevice>(session->bus, address_.vendor, address_.product, serial));
      UsbDevice& device = *session->board.back();
      std::uint32_t ticks_per_scan = 0;
      run.tick_hz[k] = set_up(device, k, ticks_per_scan).tick_hz;
      if (k > 0 && std::uint64_t{ticks_per_scan} * run.tick_hz[0] !=
                       std::uint64_t{run.ticks_per_scan[0]} * run.tick_hz[k])
        throw UsbError("its timer makes another rate than the first board's");
      run.ticks_per_scan[k] = ticks_per_scan;
      run.begin[k] = narrowest_exchange(device).instant();
    } catch (const UsbError& error) {
      throw UsbError(address_.of_board(k) + ": " + error.what());
    }
  BoardDelivery* room = inbox_.room();
  for (; !room && !stop.stop_requested(); room = inbox_.room()) std::this_thread::sleep_for(kServing);
  if (!room) return nullptr;
  room->kind = BoardDelivery::Kind::kRunBegin;
  room->run = run;
  inbox_.post();
  // To keep memory in RAM takes long when there is much of it: longer than a board's ring holds edges.
  for (const std::string& refused : enter_realtime(kDevicePriority))
    if (runs_ == 1) warn_about(0, refused);
  session->token = run.token;
  start(*session);
  return session;
}

void BoardLink::start(Session& session) {
  const std::uint32_t token = session.token;
  dropped_ = {};
  session.heard.assign(session.board.size(), WallClock::now());
  for (std::size_t k = 0; k < session.board.size(); ++k)
    session.board[k]->stream(
        [this, &session, k](std::span<const std::uint8_t> bytes) { receive(session, k, bytes); },
        *report_[k]);
  // A follower listens to SYNC before its master drives it.
  for (std::size_t k = session.board.size() - 1; k > 0; --k) {
    send_request(*session.board[k], Request::kArm, "to be armed",
                 board::Arm{token, board::StartMode::kFollower});
    if (status_of(*session.board[k]).state != board::State::kArmed)
      throw UsbError("the second board is not armed");
  }
  const bool alone = session.board.size() == 1;
  const auto mode = alone ? board::StartMode::kImmediate : board::StartMode::kMaster;
  send_request(*session.board[0], Request::kArm, "to be armed", board::Arm{token, mode});
  send_request(*session.board[0], Request::kStart, "to start", board::Start{token});
}

void BoardLink::receive(Session& session, std::size_t which, std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return;
  session.heard[which] = WallClock::now();
  BoardDelivery* const room = inbox_.room();
  if (!room) {
    ++dropped_[which];
    report_[which]->count(DeviceCounter::kReadersTooSlow);
    return;
  }
  room->kind = BoardDelivery::Kind::kTransfer;
  room->board = static_cast<std::uint8_t>(which);
  room->dropped = std::exchange(dropped_[which], 0);
  room->arrival = now();
  room->size = static_cast<std::uint32_t>(bytes.size());
  std::memcpy(room->bytes.data(), bytes.data(), bytes.size());
  inbox_.post();
}

/// The counters of the first board, whose timer stamps the node's scans.
void BoardLink::compare_clocks(Session& session) {
  const WallTime time = WallClock::now();
  if (time - session.compared < session.until_next) return;
  session.compared = time;
  session.until_next = kComparing;
  try {
    const BoardExchange exchange = narrowest_exchange(*session.board[0]);
    BoardDelivery* const room = inbox_.room();
    if (!room) return;
    room->kind = BoardDelivery::Kind::kExchange;
    room->board = 0;
    room->exchange = exchange;
    inbox_.post();
  } catch (const UsbError&) {
    // A board that is gone shows in its transfers; one that only does not answer still sends.
    report_[0]->count(DeviceCounter::kClockUnanswered);
    session.until_next = kComparingLater;
  }
}

bool BoardLink::has_failed(const Session& session, std::size_t which) {
  std::string why;
  if (dry_[which].load(std::memory_order_relaxed) == session.token)
    why = "sends, but no scans: its converter stands still, or none of its packets can be used";
  if (WallClock::now() - session.heard[which] > kLongestSilence) why = "sends nothing";
  const bool is_gone = session.board[which]->gone();
  if (why.empty() && !is_gone) return false;
  Away& away = away_[which];
  if (!std::exchange(away.is_counted, true)) report_[which]->count(DeviceCounter::kGone);
  // A board that does not mend is started every second: it is reported once.
  if (!is_gone && std::exchange(away.reported, why) != why) warn_about(which, why + "; starting it again");
  return true;
}

/// A board whose scans come (again).
void BoardLink::welcome(const Session& session, std::size_t which) {
  Away& away = away_[which];
  if (!away.is_counted || flowing_[which].load(std::memory_order_relaxed) != session.token) return;
  report_[which]->count(DeviceCounter::kReturned);
  away = {};
}

void BoardLink::serve(std::stop_token stop, Session& session) {
  while (!stop.stop_requested()) {
    session.bus.serve(kServing);
    // Its timer may have slept, too, or not: only a new session shows.
    if (MachineClock::slept() != session.slept) return;
    if (slipped_.load(std::memory_order_relaxed) == session.token)
      return report_[1]->count(DeviceCounter::kOutOfStep);
    for (std::size_t k = 0; k < session.board.size(); ++k) {
      session.board[k]->maintain();
      welcome(session, k);
      if (has_failed(session, k)) return;
    }
    compare_clocks(session);
  }
}

std::unique_ptr<BoardLink::Session> BoardLink::find_again(std::stop_token stop) {
  const WallTime since = WallClock::now();
  std::string reported;
  while (!stop.stop_requested()) {
    try {
      return begin_session(stop);
    } catch (const std::runtime_error& error) {  // UsbError, or ConfigError of another board than before
      leave_realtime();
      if (error.what() != reported && WallClock::now() - since > kPatience) {
        reported = error.what();
        warn_(reported);
      }
    }
    std::this_thread::sleep_for(kSearching);
  }
  return nullptr;
}

void BoardLink::run(std::stop_token stop, std::unique_ptr<Session> session) {
  while (session) {
    serve(stop, *session);
    session.reset();
    if (stop.stop_requested()) return;
    // Looking for a board takes the processor from those who read other devices.
    leave_realtime();
    session = find_again(stop);
  }
}

}  // namespace roadbalance
