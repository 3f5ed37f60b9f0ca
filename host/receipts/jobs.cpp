#include "host/receipts/jobs.hpp"

#include <algorithm>
#include <fstream>
#include <system_error>
#include <utility>

#include "host/recorder/desk_answers.hpp"

namespace roadbalance {
namespace {

constexpr std::size_t kKnownAnswers = 64;
constexpr double kMostKinds = 99;
constexpr std::int64_t kPatience_us = 2'000'000;  // of a program that is told to end
constexpr std::size_t kMostDocument = static_cast<std::size_t>(kMostParts) * kPartBytes;

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

/// Of what a job has written no more than shows that it is too long.
constexpr std::size_t kMostRead = kMostDocument + 1;

std::string begin_of(const std::filesystem::path& path) {
  std::string text(kMostRead, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

/// "NAME" or "NAME/BEFORE".
std::pair<std::string, std::string> names_in(const std::string& text) {
  const auto slash = text.find('/');
  if (slash == std::string::npos) return {text, ""};
  return {text.substr(0, slash), text.substr(slash + 1)};
}

const RecordingReceipt* named(const std::string& name, const std::vector<RecordingReceipt>& known) {
  if (name.empty()) return nullptr;
  const auto found = std::ranges::find(known, name, &RecordingReceipt::name);
  return found == known.end() ? nullptr : &*found;
}

std::string first_line(const std::string& text) {
  return text.substr(0, text.find('\n'));
}

/// A text that a page can show whole.
std::string shortened(std::string text) {
  static const std::string kCut = "\n... and more: rb says all of it in a terminal\n";
  if (text.size() <= kMostDocument) return text;
  const std::size_t most = kMostDocument - kCut.size();
  const std::size_t line_end = text.rfind('\n', most);
  text.resize(line_end == std::string::npos ? most : line_end);
  return text + kCut;
}

}  // namespace

Jobs::Jobs(std::filesystem::path rb, const std::filesystem::path& folder)
    : rb_(std::move(rb)), folder_(std::filesystem::absolute(folder)) {}

std::optional<Answer> Jobs::take(const Request& request, const std::vector<RecordingReceipt>& known,
                                 bool grows, std::int64_t utc_us) {
  if (!is_of_recordings(request.operation)) return std::nullopt;
  const auto before = std::ranges::find_if(answered_, [&](const Answer& answer) {
    return answer.asker == request.asker && answer.request == request.request;
  });
  if (before != answered_.end()) return *before;
  Answer answer =
      request.operation == Operation::kJob ? begin(request, known, grows, utc_us) : cancel(request, utc_us);
  answered_.push_back(answer);
  if (answered_.size() > kKnownAnswers) answered_.pop_front();
  return answer;
}

Answer Jobs::begin(const Request& request, const std::vector<RecordingReceipt>& known, bool grows,
                   std::int64_t utc_us) {
  const auto refused = [&](RefusalReason reason, std::string why) {
    return reply_to(request, AnswerState::kRefused, reason, std::move(why), utc_us);
  };
  const bool is_kind = request.value[0] >= 1 && request.value[0] <= kMostKinds;
  const auto line = job_line(static_cast<JobKind>(is_kind ? static_cast<int>(request.value[0]) : 0));
  if (!line) return refused(RefusalReason::kNotSupported, "rb-recordings does not know this job");
  const auto [name, before] = names_in(request.text);
  const RecordingReceipt* recording = named(name, known);
  const RecordingReceipt* compared = named(before, known);
  if (recording == nullptr)
    return refused(RefusalReason::kBadArgument, "there is no recording " + in_quotes(name));
  if (!before.empty() && compared == nullptr)
    return refused(RefusalReason::kBadArgument, "there is no recording " + in_quotes(before));
  if (!before.empty() && (!line->takes_before || before == name))
    return refused(RefusalReason::kBadArgument,
                   in_quotes(name) + " is not to be compared with " + in_quotes(before));
  if (grows)
    return refused(RefusalReason::kRecording,
                   "a recording is being written, and the disk is its own: ask again when it has stopped");
  if (running_)
    return refused(RefusalReason::kBusy,
                   "one job at a time: " + in_quotes(entry_[running_->place].job.recording) +
                       " is being worked on; wait, or cancel that");
  const std::size_t place = begun_ % static_cast<std::size_t>(kMostJobs);
  const auto page = work_.path() / (std::to_string(place) + ".html");
  std::error_code ignored;
  std::filesystem::remove(page, ignored);
  const auto log = work_.path() / (std::to_string(place) + ".log");
  const auto arguments =
      job_arguments(*line, folder_ / name, before.empty() ? std::filesystem::path() : folder_ / before, page);
  const double bytes = line->readings * static_cast<double>(recording->bytes) +
                       (compared == nullptr ? 0.0 : static_cast<double>(compared->bytes));
  try {
    running_.emplace(place, Child(rb_, arguments, log), page, std::max(1.0, bytes));
  } catch (const std::system_error& error) {
    return refused(RefusalReason::kNotSupported, error.what());
  }
  ++begun_;
  if (entry_.size() <= place) entry_.resize(place + 1);
  entry_[place] = {.job = {.place = static_cast<std::int32_t>(place),
                           .job = utc_us,
                           .kind = line->kind,
                           .recording = name,
                           .before = before,
                           .document_kind = line->document}};
  return reply_to(request, AnswerState::kDone, RefusalReason::kNone, in_quotes(name) + " is being worked on",
                  utc_us);
}

Answer Jobs::cancel(const Request& request, std::int64_t utc_us) {
  if (!running_ || static_cast<double>(entry_[running_->place].job.job) != request.value[0])
    return reply_to(request, AnswerState::kRefused, RefusalReason::kBadArgument, "this job has ended",
                    utc_us);
  running_->is_cancelled = true;
  running_->cancelled_us = utc_us;
  running_->child.stop();
  return reply_to(request, AnswerState::kDone, RefusalReason::kNone, "cancelled", utc_us);
}

void Jobs::turn(bool grows, std::int64_t utc_us) {
  if (!running_) return;
  Job& job = entry_[running_->place].job;
  if (const auto code = running_->child.ended()) return finish(*code, utc_us);
  if (running_->is_cancelled) {
    if (utc_us - running_->cancelled_us > kPatience_us) running_->child.end();
    return;
  }
  if (const bool is_held = job.state == JobState::kHeld; grows != is_held) {
    running_->child.hold(grows);
    job.state = grows ? JobState::kHeld : JobState::kRunning;
  }
  constexpr double kNearlyDone = 0.99;  // all is read, and something may be left to be computed
  if (const auto bytes = running_->child.bytes_read())
    job.progress =
        std::clamp(static_cast<double>(*bytes) / running_->bytes_to_read, job.progress, kNearlyDone);
}

void Jobs::finish(int code, std::int64_t utc_us) {
  Entry& entry = entry_[running_->place];
  Job& job = entry.job;
  const Child& child = running_->child;
  job.ended_us = utc_us;
  if (running_->is_cancelled) {
    job.state = JobState::kCancelled;
    job.text = "cancelled";
  } else if (code == 0 || code == 1 || code == 3) {  // of rb: done; the answer is no; incomplete and declared
    job.state = code == 0 ? JobState::kDone : JobState::kNotWell;
    job.progress = 1;
    const std::string said = child.output(kMostRead), warned = child.log(kMostRead);
    entry.document =
        job.document_kind == DocumentKind::kPage ? begin_of(running_->page) : shortened(said + warned);
    job.text = warned.empty() ? "" : first_line(warned);
    if (entry.document.size() > kMostDocument) {
      entry.document.clear();
      job.text = "it is too long to be shown: rb " + std::string(job_line(job.kind)->command) + " writes it";
    }
    job.parts = static_cast<std::int32_t>(parts_of(entry.document, job.place, job.job).size());
  } else {
    job.state = JobState::kFailed;
    job.text = child.how_it_ended();
  }
  running_.reset();
}

std::vector<Job> Jobs::told() const {
  if (entry_.empty()) return {Job{}};
  std::vector<Job> jobs;
  for (const Entry& entry : entry_) {
    jobs.push_back(entry.job);
    jobs.back().jobs = static_cast<std::int32_t>(entry_.size());
  }
  return jobs;
}

std::vector<DocumentPart> Jobs::said() {
  std::vector<DocumentPart> parts, all;
  for (Entry& entry : entry_) {
    const auto document = parts_of(entry.document, entry.job.place, entry.job.job);
    if (!document.empty() && !std::exchange(entry.is_said, true))
      parts.insert(parts.end(), document.begin(), document.end());
    all.insert(all.end(), document.begin(), document.end());
  }
  if (!all.empty()) parts.push_back(all[next_said_++ % all.size()]);
  return parts;
}

}  // namespace roadbalance
