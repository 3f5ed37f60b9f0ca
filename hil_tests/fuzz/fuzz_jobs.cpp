#include <string>
#include <variant>

#include "hil_tests/fuzz/property.hpp"
#include "host/recordings/job_book.hpp"
#include "host/recordings/job_order.hpp"

// Jobs of the page for a recording, and the file in which rb-recordings keeps them.
namespace roadbalance {
namespace {

using fuzz::require;

fuzz::Reached orders("an order"), books("a book with a job");

void check_order(std::string_view text) {
  const auto parsed = parse_job_order(text);
  if (const auto* why = std::get_if<std::string>(&parsed))
    return require(!why->empty(), "a refusal says why");
  orders.count();
  const JobOrder& order = std::get<JobOrder>(parsed);
  const std::string again = order.recording + (order.options.empty() ? "" : "/" + order.options);
  require(again == text, "an order is kept as it was asked");
  for (const auto& [key, value] : order.option) {
    require(!value.empty() && value.find('/') == std::string::npos, "a value is no way to elsewhere");
    require(order.options.find(key + "=" + value) != std::string::npos, "no option is made up");
  }
}

void check_book(std::string_view text) {
  const std::filesystem::path results = "/results";
  const auto jobs = decode_job_book(text, results);
  if (!jobs) return;
  if (!jobs->empty()) books.count();
  for (const BookedJob& booked : *jobs) {
    require(booked.result.empty() || booked.result.parent_path() == results, "a result lies in its folder");
    require(booked.result.lexically_normal() == booked.result, "and nowhere else");
    require(booked.job.recording.find('/') == std::string::npos, "a recording is a name");
  }
  const auto again = decode_job_book(encode_job_book(*jobs), results);
  require(again && again->size() == jobs->size(), "what was read is written so that it is read again");
  require(encode_job_book(*again) == encode_job_book(*jobs), "and alike");
}

}  // namespace
}  // namespace roadbalance

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  roadbalance::check_order(text);
  roadbalance::check_book(text);
  return 0;
}
