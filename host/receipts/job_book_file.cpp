#include "host/receipts/job_book_file.hpp"

#include <algorithm>
#include <cstdio>

#include "common/record/file.hpp"
#include "host/receipts/job_document.hpp"

namespace roadbalance {

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
