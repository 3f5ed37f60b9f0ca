#include "hil_tests/deterministic/host_machine.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include "common/bus/bus.hpp"
#include "common/bus/control_messages.hpp"
#include "common/config/section.hpp"
#include "common/config/vehicle_config.hpp"
#include "common/record/folder.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"
#include "common/types/crc32c.hpp"
#include "hil_tests/deterministic/host_program.hpp"
#include "host/recorder/incarnation.hpp"
#include "host/recording/manifest.hpp"
#include "host/recording/recover/recover.hpp"
#include "host/recording/verify/verify.hpp"
#include "host/recording/verify/verify_missing.hpp"
#include "host/recording/verify/verify_presence.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kDriveBegins_us = 1'790'000'000'000'000;  // of UTC
// Most blocks that a recorder may hold in memory: its credit, for each node epoch.
constexpr std::int64_t kMostWaiting = 2048 + 4096;

WallTime wall(std::int64_t ns) {
  return WallTime(std::chrono::nanoseconds(ns));
}

StoreOptions keeper_options(const FaultScenario& scenario, const std::filesystem::path& folder,
                            std::int64_t least_incarnation) {
  constexpr double kMib = 1024 * 1024;
  StoreOptions options;
  options.folder = folder;
  options.least_incarnation = least_incarnation;
  if (scenario.fallback) options.fallback = HostMachine::kFallback;
  options.segment_bytes = static_cast<std::uint64_t>(scenario.segment_mib * kMib);
  options.keep_bytes = static_cast<std::int64_t>(scenario.keep_mib * kMib);
  return options;
}

}  // namespace

HostMachine::Program::Program(Disk& disk, const FaultScenario& scenario, const RecorderLinkOptions& options,
                              const std::filesystem::path& folder, std::int64_t utc_us, std::int64_t host_ns,
                              std::int64_t first_incarnation)
    : store(disk, keeper_options(scenario, folder, std::max(utc_us / 1000, first_incarnation))),
      link(options, store.incarnation(), store.recovered()) {
  store.set_clocks(utc_us, host_ns);
  store.begin();
}

HostMachine::HostMachine(const FaultScenario& scenario, int number, std::uint64_t seed, Truth& truth)
    : scenario_(scenario),
      number_(number),
      truth_(truth),
      random_(seed, 0),
      disk_(random_.bits()),
      check_(truth),
      clock_events_(truth) {
  disk_.set_fault(
      [this](DiskCall call, std::int64_t, const std::string& path) { return disk_call(call, path); });
  disk_.set_cost([this](DiskCall call, std::size_t bytes) { return disk_cost(call, bytes); });
}

HostMachine::~HostMachine() = default;

std::int64_t HostMachine::utc_us(std::int64_t now_ns) const {
  return kDriveBegins_us + now_ns / 1000 + utc_offset_us_;
}

bool HostMachine::boot(std::int64_t now_ns) {
  paused_ = died_ = false;
  calls_to_live_ = 0;
  disk_.power_on();
  try {
    if (scenario_.is_operated()) return boot_operating(now_ns);
    RecorderLinkOptions options;
    options.seed = random_.bits();
    if (scenario_.plans(FaultKind::kLateNode))
      for (std::int32_t node = 1; node <= scenario_.nodes; ++node)
        options.expected.push_back({.number = node, .name = "n" + std::to_string(node)});
    if (boots_ == 0) began_ns_ = now_ns;
    program_ = std::make_unique<Program>(disk_, scenario_, options, kFolder, utc_us(now_ns), now_ns);
  } catch (const std::system_error&) {
    kill();
    return false;  // its supervisor tries again
  }
  durable_.clear();
  for (const auto& [key, epoch] : program_->store.recovered().epoch)
    durable_[key] = epoch.position.contiguous;
  ++boots_;
  return true;
}

std::int64_t HostMachine::ns_of(std::int64_t utc_us) const {
  return 1000 * (utc_us - kDriveBegins_us);
}

std::vector<Absence> HostMachine::absences() {
  PresenceCheck presence;
  RecordReader reader(kFolder, disk_);
  reader.finish();
  while (const auto event = reader.next()) {
    presence.take_time(event->timestamp_us);
    if (event->channel != kNoteChannel) continue;
    if (const auto note = decode_note(event->data)) presence.take(*note);
  }
  std::set<std::int32_t> ended;
  for (const Truth::Measured& one : truth_.measured())  // the last one of a node counts
    one.end != AbsenceCause::kSilent ? (void)ended.insert(one.node) : (void)ended.erase(one.node);
  return presence.absences(ended);
}

bool HostMachine::is_called_complete() {
  return verify_record(kFolder, disk_).verdict == Verdict::kComplete;
}

void HostMachine::kill() {
  died_ = false;
  if (state_may_be_old()) ++unsure_deaths_;
  disk_.kill();
  clock_events_.died();
  program_.reset();
  operating_.reset();
  calls_to_live_ = 0;
}

// Its disk has refused something within the time after which the session state is written again.
bool HostMachine::state_may_be_old() const {
  constexpr std::int64_t kWrittenAgain_ns = 1'500'000'000;
  return full_ || now_ns_ - refused_at_ns_ < kWrittenAgain_ns;
}

void HostMachine::cut_power() {
  disk_.cut_power();
  kill();
}

void HostMachine::die_at_call(bool power, int calls, bool only_syncs) {
  if (!is_up()) return;
  dies_of_power_ = power;
  dies_at_sync_ = only_syncs;
  calls_to_live_ = calls;
}

void HostMachine::take(std::string_view channel, std::span<const std::uint8_t> bytes, std::int64_t now_ns) {
  now_ns_ = now_ns;
  if (program_) program_->link.take(channel, bytes, wall(now_ns));
  for (SteppedSession* session : sessions_) session->take(channel, bytes, now_ns);
  if (operating_) operating_->take(channel, bytes, {.now = wall(now_ns), .utc_us = utc_us(now_ns)});
}

void HostMachine::watch(Program& p, const Ack& ack) {
  const std::string name =
      "recorder " + std::to_string(number_) + ", node " + std::to_string(ack.node) + ": ";
  auto [at, is_new] = p.last_ack.try_emplace({ack.node, ack.epoch}, ack);
  const Ack& last = at->second;
  if (!is_new && ack.incarnation == last.incarnation && ack.number <= last.number)
    truth_.fault(name + "an ack number does not rise");
  if (ack.incarnation < last.incarnation || ack.received < last.received || ack.durable < last.durable)
    truth_.fault(name + "an acknowledgement takes back what an earlier one said");
  if (ack.durable > ack.received) truth_.fault(name + "more is durable than received");
  EpochTruth* epoch = truth_.find(ack.node, ack.epoch);
  if (!epoch) return truth_.fault(name + "acknowledges an epoch that nobody began");
  if (ack.received >= epoch->next()) truth_.fault(name + "acknowledges what was never sealed");
  at->second = ack;
  epoch->promised = std::max(epoch->promised, ack.durable);
  check_.promised(ack.node, ack.epoch, ack.durable);
}

void HostMachine::record(RecordEvent event) {
  if (program_) program_->events.push_back(std::move(event));
}

bool HostMachine::say(Program& p, const std::string& channel, std::span<const std::uint8_t> bytes,
                      const Publish& publish) {
  if (channel.starts_with("RB_ACK_")) {
    if (const auto ack = decode_ack(bytes))
      watch(p, *ack);
    else
      truth_.fault("a recorder says an acknowledgement that no node takes");
  }
  return publish(channel, bytes);
}

void HostMachine::became_durable(Program& p, const DurableMark& mark, std::int64_t now_ns) {
  p.link.durable(mark, wall(now_ns));
  const EpochTruth* epoch = truth_.find(mark.node, mark.epoch);
  if (!epoch) return;
  std::int64_t& through = durable_[{mark.node, mark.epoch}];
  for (; through < mark.sequence; ++through)
    if (const auto* block = epoch->block(through + 1))
      longest_to_durable_s_ =
          std::max(longest_to_durable_s_, static_cast<double>(now_ns - block->sealed_ns) * 1e-9);
}

// The writing process: while a sync takes its time nothing is appended, and what comes waits.
void HostMachine::write(Program& p, std::int64_t now_ns) {
  if (now_ns < p.busy_until_ns) return;
  for (const DurableMark& mark : p.marks) became_durable(p, mark, now_ns);
  if (!p.marks.empty()) clock_events_.durable(p.events_in_commit);
  p.marks.clear();
  p.link.set_credit_open(p.store.wants_credit());
  p.store.set_clocks(utc_us(now_ns), now_ns);
  for (const RecordEvent& event : p.events) {
    clock_events_.given(event.channel, event.bytes);
    p.store.append(event, wall(now_ns));
  }
  p.events.clear();
  for (const WriteBatch& batch : p.waiting) append(p.store, batch, wall(now_ns));
  p.waiting.clear();
  p.waiting_blocks = 0;
  p.events_in_commit = clock_events_.count();
  if (p.store.commit_is_due(wall(now_ns)))
    p.marks = p.store.commit(wall(now_ns));
  else
    p.store.maintain();
  if (died_) return;
  p.busy_until_ns = now_ns + take_elapsed_ns();
}

void HostMachine::watch(const WriteBatch& batch) {
  for (const Delivery& delivery : batch.deliveries)
    if (const auto* gap = std::get_if<GapBlock>(&delivery))
      check_.declared(gap->header.node, gap->header.epoch, gap->header.sequence);
}

void HostMachine::receive(Program& p, std::int64_t now_ns, const Publish& publish) {
  if (p.link.obeyed_higher() != 0)
    p.link.set_incarnation(raise_incarnation(p.store.folder(), p.link.obeyed_higher(), disk_));
  p.link.turn(wall(now_ns), publish);
  WriteBatch batch = p.batches.take(p.link, wall(now_ns));
  if (!batch.has_content()) return;
  watch(batch);
  p.waiting_blocks += static_cast<std::int64_t>(batch.deliveries.size());
  p.waiting.push_back(std::move(batch));
  if (p.waiting_blocks > kMostWaiting * scenario_.nodes)
    truth_.fault("recorder " + std::to_string(number_) + ": holds more blocks than its credit allows");
}

void HostMachine::turn(std::int64_t now_ns, const Publish& publish) {
  if (operating_) return turn_operating(now_ns, publish);
  Program& p = *program_;
  const Publish say_it = [&](const std::string& channel, std::span<const std::uint8_t> bytes) {
    return say(p, channel, bytes, publish);
  };
  try {
    receive(p, now_ns, say_it);
    write(p, now_ns);
    if (stopping_ && end(p, now_ns, say_it)) {
      program_.reset();
      closed_ = true;
    }
  } catch (const std::system_error& error) {
    if (!died_) truth_.fault("recorder " + std::to_string(number_) + " ends: " + error.what());
    died_ = true;
  }
  if (died_) kill();
}

bool HostMachine::end(Program& p, std::int64_t now_ns, const Publish& publish) {
  p.link.stop(wall(now_ns));
  if (!p.link.over(wall(now_ns)) || !p.waiting.empty() || now_ns < p.busy_until_ns) return false;
  p.link.finish(wall(now_ns));
  const WriteBatch last = BatchMaker::take_last(p.link);
  watch(last);
  append(p.store, last, wall(now_ns));
  p.link.farewell(publish);
  p.store.close(wall(now_ns));
  return !died_;
}

void HostMachine::fill_disk(bool full) {
  const std::int64_t left = random_.below(20 << 20);
  full_ = full;
  if (!full) refused_at_ns_ = now_ns_;  // perhaps
  disk_.set_capacity(full ? disk_.used_bytes() + left : std::numeric_limits<std::int64_t>::max() / 2);
}

std::int64_t HostMachine::take_elapsed_ns() {
  const std::int64_t all_ns = disk_.busy().count();
  return all_ns - std::exchange(elapsed_seen_ns_, all_ns);
}

SimulatedDisk::Outcome HostMachine::disk_call(DiskCall call, const std::string& path) {
  if (died_)
    return {.error = EIO};  // what is left of it until its turn ends does nothing, new files included
  const bool counts = !dies_at_sync_ || call == DiskCall::kSyncData || call == DiskCall::kSync;
  if (calls_to_live_ > 0 && counts && --calls_to_live_ == 0) {
    died_ = true;
    ++deaths_at_call_;
    if (dies_of_power_) return {.power_cut = true};
    disk_.kill();  // this call and all that follow do nothing, without a sign
    return {};
  }
  const bool on_other_disk = scenario_.fallback && !path.starts_with(kFolder);
  // The kernel follows a path by itself.
  const bool can_fail = call != DiskCall::kClose && call != DiskCall::kIdentity && !on_other_disk;
  if (!can_fail || !random_.chance(failing_)) return {};
  refused_at_ns_ = now_ns_;
  constexpr std::array kErrors{EIO, ENOSPC, EROFS, EINTR};
  const auto which = static_cast<std::size_t>(random_.below(kErrors.size() + 1));
  if (which == kErrors.size()) return {.short_write = true};
  return {.error = kErrors[which]};
}

std::chrono::nanoseconds HostMachine::disk_cost(DiskCall call, std::size_t bytes) {
  constexpr double kBytes_s = 200e6;
  double seconds = static_cast<double>(bytes) / kBytes_s;
  if (call == DiskCall::kSyncData || call == DiskCall::kSync) {
    seconds += random_.between(0.001, 0.03);
    if (random_.chance(scenario_.slow_syncs))
      seconds += random_.between(scenario_.slow_sync.shortest_s, scenario_.slow_sync.longest_s);
  }
  return std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

// Segments with several behind them are finished: nothing is added to, cut from or reported of them any more.
void HostMachine::check_finished() {
  constexpr int kBehind = 4;
  if (boots_ == 0 || disk_.is_off() || scenario_.fallback || scenario_.is_operated()) return;
  // The check's own calls are none of the recorder's.
  const double failing = std::exchange(failing_, 0);
  const int calls_to_live = std::exchange(calls_to_live_, 0);
  const auto numbers = segment_numbers(kFolder, disk_);
  if (!numbers.empty()) check_through(kFolder, numbers.back() - kBehind);
  failing_ = failing;
  calls_to_live_ = calls_to_live;
}

void HostMachine::check_record() {
  if (boots_ == 0) return;
  disk_.power_on();
  failing_ = 0;
  if (scenario_.is_operated()) return check_recordings();
  if (fell_back()) make_whole();
  check_through(record_folder(), std::numeric_limits<int>::max());
  check_segments(record_folder());
  clock_events_.finish();
}

bool HostMachine::fell_back() {
  return is_folder(kFallback, disk_) && !segment_numbers(kFallback, disk_).empty();
}

// As rb recover DIR --spool FALLBACK does.
void HostMachine::make_whole() {
  try {
    const Recovered recovered = recover({kFolder, kFallback}, kWhole, disk_);
    if (recovered.gaps > 0 || recovered.blocks_altered > 0)
      truth_.fault("the two folders of recorder " + std::to_string(number_) + " together lack " +
                   std::to_string(recovered.gaps) + " runs of blocks; " +
                   std::to_string(recovered.blocks_altered) + " are altered");
    for (const std::string& line : recovered.lost)
      truth_.fault("rb recover would say that the two folders of recorder " + std::to_string(number_) +
                   " lack " + line);
    if (verify_record(kWhole, disk_).verdict == Verdict::kDamaged)
      truth_.fault("rb verify calls damaged what rb recover made of the two folders of recorder " +
                   std::to_string(number_));
    for (const char* folder : {kFolder, kFallback})
      if (verify_record(folder, disk_).verdict == Verdict::kDamaged)
        truth_.fault("rb verify calls " + std::string(folder) + " of recorder " + std::to_string(number_) +
                     " damaged, of which the rest is in another folder");
  } catch (const std::exception& error) {
    truth_.fault("the two folders of recorder " + std::to_string(number_) + ": " + error.what());
  }
}

// The product's own check of segments: the record is whole, so none may be reported missing.
void HostMachine::check_segments(const char* folder) {
  if (!is_folder(folder, disk_)) return;
  for (const std::string& line :
       find_missing_segments(folder, read_manifest(folder, disk_), deleted_, disk_).lines)
    truth_.fault("rb verify would say of the record of recorder " + std::to_string(number_) + ": " + line);
}

void HostMachine::check_through(const char* folder, int last) {
  if (last < next_to_check_) return;
  const bool all = last == std::numeric_limits<int>::max();
  const std::string name = "record " + (checked_.empty() ? "" : "\"" + checked_ + "\" ") + "of recorder " +
                           std::to_string(number_) + ": ";
  try {
    // A recorder that no node obeyed has none; the promises of one are held against the record in any case.
    if (next_to_check_ == 1 && segment_numbers(folder, disk_).empty()) return;
    RecordReader reader(folder, disk_, next_to_check_);
    if (all) reader.finish();
    const auto has_ended = [this](const NodeEpoch& key) { return check_.is_closed(key.first, key.second); };
    int segment = 0;
    while (const auto event = reader.next()) {
      if (reader.segment() > last) break;
      if (std::exchange(segment, reader.segment()) != segment)
        clock_events_.begin_segment(segment, has_ended);
      check_.take(event->channel, event->data, checked_);
      if (event->channel == kNoteChannel) take_notes(checked_, event->data);
      clock_events_.take(event->channel, event->data);
    }
    next_to_check_ = all ? last : last + 1;
    for (const auto& damage : reader.damage()) {
      if (damage.torn && may_be_torn_.contains(checked_)) continue;
      truth_.fault(name + std::to_string(damage.bytes) + " bytes of " + damage.segment.filename().string() +
                   " from " + std::to_string(damage.offset) + " on " + damage.what);
    }
  } catch (const std::system_error& error) {
    truth_.fault(name + error.what());
  }
  take_elapsed_ns();  // no program waits for the check
}

namespace {

/// The session state as it lies on the disk; read by other means than the product's.
nlohmann::json session_state_on(const SimulatedDisk& disk) {
  const auto bytes = disk.content(std::string(HostMachine::kRecordings) + "/recorder.json");
  return nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
}

}  // namespace

HostMachine::SteppedSession::SteppedSession(HostMachine& host, const RecorderOptions& options)
    : host_(host), recording_(options.folder.filename().string()) {
  RecorderLinkOptions link;
  link.start = options.start;
  link.patience = options.patience;
  link.seed = host.random_.bits();
  link.scope = options.scope;
  link.nodes = options.nodes;
  link.heard = options.heard;
  link.expected = options.expected;
  link.absent_before = options.absent_before;
  link.utc_us = host.utc_us(host.now_ns_);
  try {
    program_ = std::make_unique<Program>(host.disk_, host.scenario_, link, options.folder,
                                         host.utc_us(host.now_ns_), host.now_ns_, options.first_incarnation);
    host.may_be_torn_.erase(recording_);  // what was torn has just been cut
    for (const auto& [key, epoch] : program_->store.recovered().epoch)
      host.durable_[key] = epoch.position.contiguous;
  } catch (const std::system_error& error) {
    error_ = error.what();
  }
  host.sessions_.push_back(this);
}

HostMachine::SteppedSession::~SteppedSession() {
  std::erase(host_.sessions_, this);
}

Session::View HostMachine::SteppedSession::view() const {
  View view{.report = program_ ? program_->link.report() : report_,
            .status = status_,
            .is_over = !program_,
            .error = error_};
  if (program_) {
    view.report.absence = program_->link.absences(wall(host_.now_ns_), host_.utc_us(host_.now_ns_));
    program_->store.fill(view.status.emplace());
    program_->link.fill(*view.status);
  }
  return view;
}

void HostMachine::SteppedSession::take(std::string_view channel, std::span<const std::uint8_t> bytes,
                                       std::int64_t now_ns) {
  if (program_) program_->link.take(channel, bytes, wall(now_ns));
}

void HostMachine::SteppedSession::fail(const std::string& why) {
  if (has_run_) status_ = view().status;
  report_ = program_->link.report();
  report_.absence = program_->link.absences(wall(host_.now_ns_), host_.utc_us(host_.now_ns_));
  report_.marks = program_->store.durable_marks();
  error_ = why;
  program_.reset();
  if (host_.failing_ > 0) host_.may_be_torn_.insert(recording_);
}

void HostMachine::SteppedSession::turn(std::int64_t now_ns, const Publish& publish) {
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
      p.store.note(note.kind, note.a, note.b, note.text, wall(now_ns) - note.at);
    host_.write(p, now_ns);
    if (!stopping_ || !host_.end(p, now_ns, say_it)) return;
    fail(p.store.failure().value_or(""));
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
  sessions_.clear();
  operating_ = std::make_unique<Operating>(
      operate_,
      Operating::World{.disk = disk_,
                       .begin = [this](const RecorderOptions& options) { return begin_session(options); },
                       .seed = random_.bits()},
      Operating::Time{.now = wall(now_ns), .utc_us = utc_us(now_ns)});
  ++boots_;
  return true;
}

std::unique_ptr<Session> HostMachine::begin_session(const RecorderOptions& options) {
  check_begun(options);
  return std::make_unique<SteppedSession>(*this, options);
}

// A recording that begins was in the session state before, for one request only.
void HostMachine::check_begun(const RecorderOptions& options) {
  if (died_) return;
  const std::string name = options.folder.filename().string();
  const nlohmann::json state = session_state_on(disk_);
  // If it could not be written, the session state has it as being stopped: whoever reads it does that again.
  const auto is_owed = [&] {
    if (state_may_be_old()) return true;
    if (state.contains("under_way") && state["under_way"]["name"] == name) return true;
    for (const auto& rest : state.value("rest", nlohmann::json::array()))
      if (rest.at(0) == name) return true;
    return false;
  };
  if (!options.start) {
    if (!is_owed()) truth_.fault("the rest of \"" + name + "\" is fetched, and no session state has it");
    return;
  }
  if (!state.contains("under_way") || state["under_way"]["name"] != name)
    return truth_.fault("\"" + name + "\" is begun before the session state has it");
  const auto& start = state["under_way"]["start"];
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
      const nlohmann::json state = session_state_on(disk_);
      if (!state.contains("set_up") || state["set_up"]["state"] != static_cast<int>(AnswerState::kUnderWay))
        truth_.fault("nodes are set up before the session state has it");
    }
    if (const auto answer = channel == kAnswerChannel ? decode_answer(bytes) : std::nullopt; answer && !died_)
      watch(*answer);
    return died_ || publish(channel, bytes);
  };
  for (SteppedSession* session : std::vector<SteppedSession*>(sessions_)) session->turn(now_ns, publish);
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

// As it is sent, whatever the network does to it: an asker that repeats a request because the answer was lost
// must not get a refusal when it has been done.
void HostMachine::watch(const Answer& answer) {
  if (answer.state == AnswerState::kUnderWay) return;
  const Word now{answer.state, boots_, unsure_deaths_};
  const auto [said, is_new] = reported_.try_emplace({answer.asker, answer.request}, now);
  Word& before = said->second;
  const bool was_done = before.state == AnswerState::kDone;
  const bool is_done = answer.state == AnswerState::kDone;
  if (is_done && (is_new || !was_done)) check_file(answer);
  if (was_done == is_done) {
    before = now;  // sent by this recorder, too
    return;
  }
  // Requests that are done are in the session state, which a failing disk may not have taken.  A refusal is
  // not: the next recorder may obey an asker that has not heard it and asks again.
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
  // Once more under the same number: it was not known whether it was on the disk.
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
