#include "host/recordings/job_book.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <variant>

#include "common/bus/operation.hpp"
#include "common/bus/wire_text.hpp"
#include "common/record/file.hpp"
#include "common/text/json_number.hpp"
#include "host/recordings/job_document.hpp"
#include "host/recordings/job_order.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostText = 300;  // as common/wire/job_t: so the book stays within kMostRead

Json to_json(const BookedJob& booked) {
  const Job& job = booked.job;
  return {{"job", job.job},
          {"kind", static_cast<int>(job.kind)},
          {"state", static_cast<int>(job.state)},
          {"recording", job.recording},
          {"options", job.options},
          {"began_us", job.began_us},
          {"ended_us", job.ended_us},
          {"elapsed_s", job.elapsed_s},
          {"text", std::string(wire_text::cut_to(job.text, kMostText))},
          {"asked", {booked.asker, booked.request}},
          {"result", booked.result.filename().string()}};
}

double seconds(const Json& json) {
  const double value = json.is_number() ? json.get<double>() : -1.0;
  constexpr double kMost_s = 1e9;
  if (!(value >= 0.0 && value <= kMost_s)) throw std::out_of_range("no time");
  return value;
}

std::optional<BookedJob> booked_of(const Json& json, const std::filesystem::path& results) {
  BookedJob booked{.job = {.job = whole_number(json.at("job")),
                           .kind = static_cast<JobKind>(small_number(json.at("kind"))),
                           .state = static_cast<JobState>(small_number(json.at("state"))),
                           .recording = json.at("recording").get<std::string>(),
                           .options = json.at("options").get<std::string>(),
                           .began_us = whole_number(json.at("began_us")),
                           .ended_us = whole_number(json.at("ended_us")),
                           .elapsed_s = seconds(json.at("elapsed_s")),
                           .text = json.at("text").get<std::string>()},
                   .asker = whole_number(json.at("asked").at(0)),
                   .request = whole_number(json.at("asked").at(1))};
  const Job& job = booked.job;
  if (job.kind < JobKind::kVerify || job.kind > JobKind::kTransfer || job.state < JobState::kRunning ||
      job.state > JobState::kInterrupted)
    return std::nullopt;
  const auto order = parse_job_order(job.recording + (job.options.empty() ? "" : "/" + job.options));
  if (!std::holds_alternative<JobOrder>(order) || std::get<JobOrder>(order).recording != job.recording)
    return std::nullopt;
  // An unfinished result is removed: it must be a plain name and no path.
  const auto result = json.at("result").get<std::string>();
  if (result == "." || result == ".." || result.find('/') != std::string::npos ||
      result.find('\0') != std::string::npos)
    return std::nullopt;
  if (!result.empty()) booked.result = results / result;
  return booked;
}

}  // namespace

std::string encode_job_book(const std::vector<BookedJob>& jobs) {
  Json json = Json::array();
  for (const BookedJob& booked : jobs) json.push_back(to_json(booked));
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::optional<std::vector<BookedJob>> decode_job_book(std::string_view text,
                                                      const std::filesystem::path& results) {
  try {
    const Json json = Json::parse(text);
    if (!json.is_array() || json.size() > static_cast<std::size_t>(kMostJobs)) return std::nullopt;
    std::vector<BookedJob> jobs;
    for (const Json& each : json) {
      auto booked = booked_of(each, results);
      if (!booked) return std::nullopt;
      jobs.push_back(std::move(*booked));
    }
    return jobs;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::vector<BookedJob> JobBookFile::read() const {
  const auto file = results_ / kJobBookFile;
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return {};
  if (auto jobs = decode_job_book(begin_of(file), results_)) return *std::move(jobs);
  std::fprintf(stderr, "rb-recordings: %s: cannot be read; the jobs of before are not told\n", file.c_str());
  return {};
}

void JobBookFile::write(std::vector<BookedJob> jobs) const {
  std::ranges::sort(jobs, {}, [](const BookedJob& booked) { return booked.job.job; });
  std::filesystem::create_directories(results_);
  write_atomically(results_ / kJobBookFile, encode_job_book(jobs));
}

}  // namespace roadbalance
