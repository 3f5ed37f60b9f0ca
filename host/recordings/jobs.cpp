#include "host/recordings/jobs.hpp"

#include <signal.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "common/record/failure_words.hpp"
#include "host/recordings/job_document.hpp"
#include "host/recordings/job_results.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kKnownAnswers = 64;
constexpr double kMostKinds = 99;
constexpr std::chrono::seconds kPatience{2};   // with a program that was asked to end
constexpr std::chrono::seconds kBookAgain{5};  // after a disk has refused it
constexpr int kBySignal = 128, kCannotExecute = 127;
constexpr const char* kOfRb = "rb: ";

/// The disk does not take the book of jobs.
struct BookRefused : std::runtime_error {
  using std::runtime_error::runtime_error;
};

Answer reply_to(const Request& request, AnswerState state, RefusalReason reason, std::string text,
                std::int64_t utc_us) {
  Answer answer = answer_to(request, utc_us);
  answer.state = state;
  answer.reason = reason;
  answer.text = std::move(text);
  return answer;
}

std::string in_quotes(const std::string& name) {
  return "\"" + name + "\"";
}

/// Its result appears whole among the results; if it is ended nothing is left of it.
bool is_whole_or_nothing(JobOutcome outcome) {
  return outcome == JobOutcome::kFile || outcome == JobOutcome::kRecording;
}

/// It leaves something on a disk, if only half of it.
bool stays(JobOutcome outcome) {
  return is_whole_or_nothing(outcome) || outcome == JobOutcome::kCopy;
}

/// The remains of a job that was ended; begins with "; ", or is empty.
std::string left_of(JobOutcome outcome) {
  if (outcome == JobOutcome::kCopy) return "; what is copied already stays there, and begun again it goes on";
  return is_whole_or_nothing(outcome) ? "; nothing is left of it, and begun again it begins anew" : "";
}

/// Why a command of rb could not do its work, and what to do: the last words of rb, or how it was ended.
std::string words_of_failure(const JobLine& line, Child& ended) {
  const int code = ended.ended().value_or(0);
  const std::string command = "rb " + std::string(line.command);
  if (code == kBySignal + SIGKILL)
    return command +
           " was ended from outside, as a computer short of memory does: end other programs, or take a part" +
           left_of(line.outcome);
  if (code == kBySignal + SIGTERM || code == kBySignal + SIGINT || code == kBySignal + SIGHUP)
    return command + " was told to end, not by rb-recordings" + left_of(line.outcome);
  if (code > kBySignal)
    return command + " broke off (signal " + std::to_string(code - kBySignal) +
           "), which is a fault of the program: run it in a terminal and report what it says" +
           left_of(line.outcome);
  if (code == kCannotExecute) return command + " cannot be run: install roadbalance again";
  const std::string words = ended.last_words();
  return words.starts_with(kOfRb) ? words.substr(std::string_view(kOfRb).size()) : words;
}

const ListedRecording* named(const std::string& name, const std::vector<ListedRecording>& known) {
  if (name.empty()) return nullptr;
  const auto found =
      std::ranges::find(known, name, [](const ListedRecording& each) { return each.summary.name; });
  return found == known.end() ? nullptr : &*found;
}

/// Numbers only grow, even if the clock is set back: the page orders jobs by them.
std::int64_t next_number(const std::vector<Job>& reported, std::int64_t utc_us) {
  for (const Job& job : reported) utc_us = std::max(utc_us, job.job + 1);
  return utc_us;
}

double seconds(WallTime::duration time) {
  return std::chrono::duration<double>(time).count();
}

}  // namespace

Jobs::Jobs(std::filesystem::path rb, const JobPlaces& places)
    : rb_(std::move(rb)), places_(places), book_(places.results) {
  read_book();
}

std::optional<Answer> Jobs::take(const Request& request, const std::vector<ListedRecording>& known,
                                 bool grows, const JobInstant& now) {
  if (!is_of_recordings(request.operation)) return std::nullopt;
  const auto before = std::ranges::find_if(answered_, [&](const Answer& answer) {
    return answer.asker == request.asker && answer.request == request.request;
  });
  if (before != answered_.end()) return *before;
  Answer answer =
      request.operation == Operation::kJob ? begin(request, known, grows, now) : cancel(request, now);
  answered_.push_back(answer);
  if (answered_.size() > kKnownAnswers) answered_.pop_front();
  return answer;
}

Answer Jobs::begin(const Request& request, const std::vector<ListedRecording>& known, bool grows,
                   const JobInstant& now) {
  const auto refused = [&](RefusalReason reason, std::string why) {
    return reply_to(request, AnswerState::kRefused, reason, std::move(why), now.utc_us);
  };
  const bool is_kind = request.value[0] >= 1 && request.value[0] <= kMostKinds;
  auto line = job_line(static_cast<JobKind>(is_kind ? static_cast<int>(request.value[0]) : 0));
  if (!line) return refused(RefusalReason::kNotSupported, "rb-recordings does not know this job");
  const auto parsed = parse_job_order(request.text);
  if (const auto* why = std::get_if<std::string>(&parsed)) return refused(RefusalReason::kBadArgument, *why);
  const JobOrder& order = std::get<JobOrder>(parsed);
  const ListedRecording* recording = named(order.recording, known);
  if (recording == nullptr)
    return refused(RefusalReason::kBadArgument, "there is no recording " + in_quotes(order.recording));
  if (const std::string why = fault_of_order(*line, order); !why.empty())
    return refused(RefusalReason::kBadArgument, why);
  line->outcome = outcome_of(*line, order);
  const auto compared = order.option.find("before");
  const ListedRecording* before = compared == order.option.end() ? nullptr : named(compared->second, known);
  if (compared != order.option.end() && (before == nullptr || before == recording))
    return refused(RefusalReason::kBadArgument,
                   before == nullptr ? "there is no recording " + in_quotes(compared->second)
                                     : in_quotes(order.recording) + " is not to be compared with itself");
  if (line->outcome == JobOutcome::kCopy && places_.transfer_to.empty())
    return refused(RefusalReason::kNotSupported,
                   "no place for copies is known: start rb-recordings with --transfer-to FOLDER");
  if (grows)
    return refused(RefusalReason::kRecording,
                   "a recording is being written, and the disk is its own: ask again when it has stopped");
  if (running_)
    return refused(RefusalReason::kBusy,
                   "one job at a time: " + in_quotes(entry_[running_->place].booked.job.recording) +
                       " is being worked on; wait, or cancel that");
  BookedJob booked{.job = {.job = next_number(reported(), now.utc_us),
                           .kind = line->kind,
                           .recording = order.recording,
                           .options = order.options,
                           .began_us = now.utc_us},
                   .asker = request.asker,
                   .request = request.request};
  try {
    run(*line, order, *recording, before, std::move(booked), known, now.steady);
  } catch (const BookRefused& error) {
    return refused(RefusalReason::kDisk, error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return refused(RefusalReason::kDisk, failure_words(error));
  } catch (const std::exception& error) {
    return refused(RefusalReason::kNotSupported, failure_words(error));
  }
  return reply_to(request, AnswerState::kDone, RefusalReason::kNone,
                  in_quotes(order.recording) + " is being worked on", now.utc_us);
}

void Jobs::run(const JobLine& line, const JobOrder& order, const ListedRecording& recording,
               const ListedRecording* before, BookedJob booked, const std::vector<ListedRecording>& known,
               WallTime now) {
  const std::size_t place = begun_ % static_cast<std::size_t>(kMostJobs);
  const auto page = work_.path() / (std::to_string(place) + ".html");
  std::error_code ignored;
  std::filesystem::remove(page, ignored);
  std::filesystem::path to = line.outcome == JobOutcome::kCopy ? places_.transfer_to : page;
  if (is_whole_or_nothing(line.outcome)) {
    std::filesystem::create_directories(places_.results);
    to = booked.result = free_place(places_.results, result_name(line, order), [&](const std::string& name) {
      const auto with = beside(order, places_.results / name);
      return named(name, known) != nullptr || (!with.empty() && std::filesystem::exists(with));
    });
  }
  const auto arguments =
      job_arguments(line, order, recording.folder, before == nullptr ? "" : before->folder, to);
  booked.job.place = static_cast<std::int32_t>(place);
  booked.job.document_kind = line.outcome == JobOutcome::kPage ? DocumentKind::kPage : DocumentKind::kText;
  booked.job.bytes_to_read =
      bytes_to_read(line, order, recording.summary, before == nullptr ? 0 : before->summary.bytes);
  std::vector<Entry> entries = entry_;
  if (entries.size() <= place) entries.resize(place + 1);
  entries[place] = {.booked = std::move(booked)};
  try {
    write_book(entries);
  } catch (const std::exception& error) {
    const std::string why = failure_words(error);
    if (stays(line.outcome))
      throw BookRefused("the book of jobs cannot be written, so nothing was begun: " + why);
    std::fprintf(stderr, "rb-recordings: %s\n", why.c_str());
  }
  try {
    // When this program begins again, it discards what this one leaves, or goes on with it.
    running_.emplace(Running{.place = place,
                             .line = line,
                             .began = now,
                             .child = Child(rb_, arguments, work_.path() / (std::to_string(place) + ".log"),
                                            Child::Orphan::kIsEnded),
                             .page = page});
  } catch (const std::exception&) {
    try_write_book(now);
    throw;
  }
  ++begun_;
  entry_ = std::move(entries);
}

Answer Jobs::cancel(const Request& request, const JobInstant& now) {
  if (!running_ || static_cast<double>(entry_[running_->place].booked.job.job) != request.value[0])
    return reply_to(request, AnswerState::kRefused, RefusalReason::kBadArgument, "this job has ended",
                    now.utc_us);
  running_->cancelled = now.steady;
  running_->child.stop();
  return reply_to(request, AnswerState::kDone, RefusalReason::kNone, "cancelled", now.utc_us);
}

void Jobs::turn(bool grows, const JobInstant& now) {
  if (book_failed_ && now.steady - *book_failed_ > kBookAgain) try_write_book(now.steady);
  if (!running_) return;
  Job& job = entry_[running_->place].booked.job;
  job.elapsed_s = seconds(now.steady - running_->began);
  if (const auto code = running_->child.ended()) return finish(*code, now);
  if (running_->cancelled) {
    if (now.steady - *running_->cancelled > kPatience) running_->child.end();
    return;
  }
  if (const bool is_held = job.state == JobState::kHeld; grows != is_held) {
    running_->child.hold(grows);
    running_->rate.forget();
    job.state = grows ? JobState::kHeld : JobState::kRunning;
  }
  constexpr double kNearlyDone = 0.99;  // all is read, but the rest of the computation may follow
  if (const auto bytes = running_->child.bytes_read()) {
    if (job.state == JobState::kRunning) running_->rate.take(*bytes, now.steady);
    job.bytes = std::max(job.bytes, *bytes);
    job.bytes_per_s = running_->rate.bytes_per_s();
    job.progress = std::clamp(static_cast<double>(*bytes) / static_cast<double>(job.bytes_to_read),
                              job.progress, kNearlyDone);
  }
}

void Jobs::finish(int code, const JobInstant& now) {
  Entry& entry = entry_[running_->place];
  Job& job = entry.booked.job;
  const JobOutcome outcome = running_->line.outcome;
  job.ended_us = now.utc_us;
  job.bytes_per_s = 0;
  if (code == 0 || code == 1 ||
      code == 3) {  // exit codes of rb: done; the answer is no; incomplete and declared
    job.state = code == 0 ? JobState::kDone : JobState::kNotWell;
    job.progress = 1;
    take_document(entry);
  } else {
    if (is_whole_or_nothing(outcome)) discard_half(entry.booked.result);
    job.state = running_->cancelled ? JobState::kCancelled : JobState::kFailed;
    job.text = running_->cancelled ? "cancelled" + left_of(outcome)
                                   : words_of_failure(running_->line, running_->child);
  }
  running_.reset();
  try_write_book(now.steady);
}

void Jobs::take_document(Entry& entry) const {
  Job& job = entry.booked.job;
  const std::string output = running_->child.output(kMostRead), warnings = running_->child.log(kMostRead);
  entry.document =
      job.document_kind == DocumentKind::kPage ? begin_of(running_->page) : shortened(output + warnings);
  job.text = warnings.empty() ? "" : first_line(warnings);
  if (is_whole_or_nothing(running_->line.outcome)) job.text = words_of(entry.booked.result);
  if (running_->line.outcome == JobOutcome::kCopy) job.text = first_line(output);
  if (entry.document.size() > kMostDocument) {
    entry.document.clear();
    job.text = "it is too long to be shown: rb " + std::string(running_->line.command) + " writes it";
  }
  job.parts = static_cast<std::int32_t>(parts_of(entry.document, job.place, job.job).size());
}

void Jobs::read_book() {
  for (BookedJob& booked : book_.read()) {
    Job& job = booked.job;
    auto line = job_line(job.kind);
    if (!line) continue;
    if (const auto order = parse_job_order(job.recording + "/" + job.options); order.index() == 0)
      line->outcome = outcome_of(*line, std::get<JobOrder>(order));
    job.place = static_cast<std::int32_t>(entry_.size());
    if (job.state == JobState::kRunning || job.state == JobState::kHeld) {
      const bool is_made = !booked.result.empty() && std::filesystem::exists(booked.result);
      if (!booked.result.empty()) discard_half(booked.result);
      job.state = is_made ? JobState::kDone : JobState::kInterrupted;
      job.text =
          is_made ? words_of(booked.result) : "interrupted: rb-recordings ended" + left_of(line->outcome);
    }
    const Request request{.asker = booked.asker, .request = booked.request, .operation = Operation::kJob};
    answered_.push_back(reply_to(request, AnswerState::kDone, RefusalReason::kNone,
                                 in_quotes(job.recording) + " was being worked on", job.job));
    entry_.push_back({.booked = std::move(booked)});
  }
  begun_ = entry_.size();
}

void Jobs::write_book(const std::vector<Entry>& entries) const {
  std::vector<BookedJob> jobs;
  for (const Entry& entry : entries) jobs.push_back(entry.booked);
  book_.write(std::move(jobs));
}

/// A finished job counts even if the book cannot be written: it is reported while this program runs, and the
/// book follows when its disk takes it again.
void Jobs::try_write_book(WallTime now) {
  const bool is_new = !book_failed_;
  try {
    write_book(entry_);
    book_failed_.reset();
  } catch (const std::exception& error) {
    book_failed_ = now;
    if (is_new) std::fprintf(stderr, "rb-recordings: %s\n", failure_words(error).c_str());
  }
}

std::vector<Job> Jobs::reported() const {
  if (entry_.empty()) return {Job{.transfer_to = places_.transfer_to.string()}};
  std::vector<Job> jobs;
  for (const Entry& entry : entry_) {
    jobs.push_back(entry.booked.job);
    jobs.back().jobs = static_cast<std::int32_t>(entry_.size());
    jobs.back().transfer_to = places_.transfer_to.string();
  }
  return jobs;
}

std::vector<DocumentPart> Jobs::due_parts() {
  std::vector<DocumentPart> parts, all;
  for (Entry& entry : entry_) {
    const auto document = parts_of(entry.document, entry.booked.job.place, entry.booked.job.job);
    if (!document.empty() && !std::exchange(entry.is_sent, true))
      parts.insert(parts.end(), document.begin(), document.end());
    all.insert(all.end(), document.begin(), document.end());
  }
  if (!all.empty()) parts.push_back(all[next_reported_++ % all.size()]);
  return parts;
}

}  // namespace roadbalance
