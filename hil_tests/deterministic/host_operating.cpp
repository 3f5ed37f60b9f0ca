#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/control.hpp"
#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/link/crc32c.hpp"
#include "common/record/folder.hpp"
#include "hil_tests/deterministic/host_program.hpp"

namespace roadbalance::test {
namespace {

WallTime wall(std::int64_t ns) {
  return WallTime(std::chrono::nanoseconds(ns));
}

/// The book as it lies on the disk; read by other means than the product's.
nlohmann::json book_on(const SimulatedDisk& disk) {
  const auto bytes = disk.content(std::string(HostMachine::kRecordings) + "/recorder.json");
  return nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
}

}  // namespace

HostMachine::Led::Led(HostMachine& host, const RecorderOptions& options)
    : host_(host), recording_(options.folder.filename().string()) {
  RecorderLinkOptions link;
  link.start = options.start;
  link.patience = options.patience;
  link.seed = host.random_.bits();
  link.scope = options.scope;
  try {
    program_ = std::make_unique<Program>(host.disk_, host.scenario_, link, options.folder,
                                         host.utc_us(host.now_ns_), host.now_ns_, options.first_incarnation);
    host.may_be_torn_.erase(recording_);  // what was torn has just been cut
    for (const auto& [key, epoch] : program_->keeper.recovered().epoch)
      host.durable_[key] = epoch.position.contiguous;
  } catch (const std::system_error& error) {
    error_ = error.what();
  }
  host.led_.push_back(this);
}

HostMachine::Led::~Led() {
  std::erase(host_.led_, this);
}

Session::View HostMachine::Led::view() const {
  View view{.report = program_ ? program_->link.report() : report_,
            .status = status_,
            .is_over = !program_,
            .error = error_};
  if (program_) {
    program_->keeper.fill(view.status.emplace());
    program_->link.fill(*view.status);
  }
  return view;
}

void HostMachine::Led::take(std::string_view channel, std::span<const std::uint8_t> bytes,
                            std::int64_t now_ns) {
  if (program_) program_->link.take(channel, bytes, wall(now_ns));
}

void HostMachine::Led::fail(const std::string& why) {
  if (has_run_) status_ = view().status;
  report_ = program_->link.report();
  report_.marks = program_->keeper.durable_marks();
  error_ = why;
  program_.reset();
  if (host_.failing_ > 0) host_.may_be_torn_.insert(recording_);
}

void HostMachine::Led::turn(std::int64_t now_ns, const Publish& publish) {
  if (!program_) return;
  has_run_ = true;
  Program& p = *program_;
  host_.truth_.leads(p.link.incarnation(), recording_);
  const Publish say_it = [&](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return host_.say(p, channel, bytes, publish);
  };
  try {
    host_.receive(p, now_ns, say_it);
    for (const NoteToRecord& note : std::exchange(notes_, {}))
      p.keeper.note(note.kind, note.a, note.b, note.text, wall(now_ns) - note.at);
    host_.write(p, now_ns);
    if (!stopping_ || !host_.end(p, now_ns, say_it)) return;
    fail(p.keeper.failure().value_or(""));
  } catch (const std::system_error& error) {
    if (!host_.died_) fail(error.what());
  }
}

bool HostMachine::boot_operating(std::int64_t now_ns) {
  if (boots_ == 0) {
    for (const char* folder : {"/vehicle", kRecordings}) disk_.mkdir(folder, 0755);
    sync_folder("/", disk_);  // long ago: no power cut takes them
    disk_.put(kVehicleOnDisk, {scenario_.vehicle.begin(), scenario_.vehicle.end()});
    operate_.recordings = kRecordings;
    operate_.vehicle = kVehicleOnDisk;
  }
  now_ns_ = now_ns;
  durable_.clear();
  led_.clear();
  operating_ = std::make_unique<Operating>(
      operate_,
      Operating::World{.disk = disk_,
                       .begin = [this](const RecorderOptions& options) { return lead(options); },
                       .seed = random_.bits()},
      Operating::Time{.now = wall(now_ns), .utc_us = utc_us(now_ns)});
  ++boots_;
  return true;
}

std::unique_ptr<Session> HostMachine::lead(const RecorderOptions& options) {
  check_begun(options);
  return std::make_unique<Led>(*this, options);
}

// What is begun was in the book before, and for one request only.
void HostMachine::check_begun(const RecorderOptions& options) {
  if (died_) return;
  const std::string name = options.folder.filename().string();
  const nlohmann::json book = book_on(disk_);
  // A book that could not be written leaves it as being stopped: whoever reads it then does that again.
  const auto is_owed = [&] {
    if (book_may_be_old()) return true;
    if (book.contains("under_way") && book["under_way"]["name"] == name) return true;
    for (const auto& rest : book.value("rest", nlohmann::json::array()))
      if (rest.at(0) == name) return true;
    return false;
  };
  if (!options.start) {
    if (!is_owed()) truth_.fault("the rest of \"" + name + "\" is fetched, and no book says so");
    return;
  }
  if (!book.contains("under_way") || book["under_way"]["name"] != name)
    return truth_.fault("\"" + name + "\" is begun before the book says so");
  const auto& start = book["under_way"]["start"];
  const std::pair<std::int64_t, std::int64_t> asked{start.at(0), start.at(1)};
  const auto [known, is_new] = begun_by_.try_emplace(name, asked);
  if (known->second != asked) truth_.fault("\"" + name + "\" is begun for two requests");
  if (!is_new) return;
  for (const auto& [other, by] : begun_by_)
    if (other != name && by == asked)
      truth_.fault("one request began \"" + other + "\" and \"" + name + "\"");
}

void HostMachine::turn_operating(std::int64_t now_ns, const Publish& publish) {
  now_ns_ = now_ns;
  const Publish say_it = [&](const std::string& channel, std::span<const std::uint8_t> bytes) {
    if (const auto command = decode_command(bytes); command && command->verb == Verb::kConfigure && !died_) {
      const nlohmann::json book = book_on(disk_);
      if (!book.contains("set_up") || book["set_up"]["state"] != static_cast<int>(AnswerState::kUnderWay))
        truth_.fault("nodes are set up before the book says so");
    }
    if (const auto answer = channel == kAnswerChannel ? decode_answer(bytes) : std::nullopt; answer && !died_)
      watch(*answer);
    return died_ || publish(channel, bytes);
  };
  for (Led* led : std::vector<Led*>(led_)) led->turn(now_ns, publish);
  try {
    if (!died_) (void)operating_->turn(false, {.now = wall(now_ns), .utc_us = utc_us(now_ns)}, say_it);
  } catch (const std::system_error& error) {
    if (!died_) truth_.fault(std::string("an operated recorder ends: ") + error.what());
    died_ = true;
  }
  if (died_) return kill();
  if (!stopping_ || has_work()) return;
  closed_ = true;
  operating_.reset();
}

// As it is said, whatever the network makes of it: who repeats a request because the answer was lost must not
// hear that it is refused when it has been done.
void HostMachine::watch(const Answer& answer) {
  if (answer.state == AnswerState::kUnderWay) return;
  const Word now{answer.state, boots_, unsure_deaths_};
  const auto [said, is_new] = said_.try_emplace({answer.asker, answer.request}, now);
  Word& before = said->second;
  const bool was_done = before.state == AnswerState::kDone;
  const bool is_done = answer.state == AnswerState::kDone;
  if (is_done && (is_new || !was_done)) check_file(answer);
  if (was_done == is_done) {
    before = now;  // said by this recorder, too
    return;
  }
  // What is done is in the book, which a disk that fails may not have taken.  A refusal is not: the next
  // recorder may obey who has not heard it and asks again.
  if (before.unsure_deaths == unsure_deaths_ && (was_done || before.boots == boots_))
    truth_.fault("request " + std::to_string(answer.request) + " of asker " + std::to_string(answer.asker) +
                 (was_done ? " is refused after it was done: " : " is done after it was refused: ") +
                 answer.text);
  before = now;
}

// A set-up that is done is in the file.
void HostMachine::check_file(const Answer& done) {
  if (done.operation != Operation::kRange && done.operation != Operation::kFilter) return;
  const auto bytes = disk_.content(kVehicleOnDisk);
  try {
    const VehicleConfig car = VehicleConfig::parse({bytes.begin(), bytes.end()}, kVehicleOnDisk);
    const NodeConfig* node = car.node_with_id(done.node);
    const bool is_there =
        done.operation == Operation::kFilter
            ? car.filter.cutoff_hz == done.value[0]
            : node && node->channel.at(static_cast<std::size_t>(done.channel)).range_m_s2 == done.value[0];
    if (!is_there) truth_.fault("a set-up is said to be done and not in the file: " + done.text);
  } catch (const ConfigError& error) {
    truth_.fault(std::string("a set-up is said to be done and its file cannot be read: ") + error.what());
  }
}

bool HostMachine::has_work() const {
  return operating_ && operating_->has_work();
}

std::uint32_t HostMachine::vehicle_crc32c() {
  return crc32c(disk_.content(kVehicleOnDisk));
}

void HostMachine::check_recordings() {
  for (const std::string& name : list_folder(kRecordings, disk_)) {
    const std::string folder = std::string(kRecordings) + "/" + name;
    if (!is_folder(folder, disk_)) continue;
    if (!begun_by_.contains(name)) truth_.fault("nobody began \"" + name + "\"");
    checked_ = name;
    next_to_check_ = 1;
    deleted_.clear();
    check_through(folder.c_str(), std::numeric_limits<int>::max());
    check_segments(folder.c_str());
  }
}

void HostMachine::take_notes(const std::string& recording, std::span<const std::uint8_t> bytes) {
  const auto note = decode_note(bytes);
  if (note && note->kind == NoteKind::kSegmentDeleted) deleted_.insert(static_cast<int>(note->a));
  if (note && note->kind == NoteKind::kDiskFull) ++disk_fulls_;
  if (!note || note->kind != NoteKind::kMark) return;
  const auto [known, is_new] = marks_.try_emplace(note->text, FoundMark{recording, note->a});
  // Once more under the same number: nobody knew whether it was on the disk.
  if (!is_new && (known->second.recording != recording || known->second.number != note->a))
    truth_.fault("\"" + note->text + "\" is set twice");
}

bool HostMachine::disk_may_fail() const {
  return scenario_.plans(FaultKind::kDiskFull) || scenario_.plans(FaultKind::kDiskFailing);
}

void HostMachine::check_asked(const std::vector<Asker::Asked>& asked) {
  for (const auto& [request, at_ns, unsure_deaths, answer, is_unsure, under_way] : asked) {
    const bool done = answer && answer->state == AnswerState::kDone;
    const bool refused = answer && answer->state == AnswerState::kRefused;
    if (request.operation == Operation::kStop && !answer)
      truth_.fault("a stop is under way for ever, said last: \"" + under_way + "\"");
    if (request.operation == Operation::kStart && done && !begun_by_.contains(request.text))
      truth_.fault("\"" + request.text + "\" was never begun and its start is done");
    if (request.operation == Operation::kStart && refused && answer->reason != RefusalReason::kDisk &&
        begun_by_.contains(request.text))
      truth_.fault("\"" + request.text + "\" was begun and its start is refused: " + answer->text);
    if (request.operation != Operation::kMark || !answer) continue;
    const auto found = marks_.find(request.text);
    if (done && found == marks_.end()) truth_.fault("\"" + request.text + "\" is done and not in the record");
    const bool may_be_there = answer->reason == RefusalReason::kDisk && disk_may_fail();
    if (refused && !may_be_there && !is_unsure && found != marks_.end())
      truth_.fault("\"" + request.text + "\" is refused and in the record");
  }
}

}  // namespace roadbalance::test
