#include "host/excerpt/find_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/config/section.hpp"
#include "host/excerpt/judged_time.hpp"

namespace roadbalance {
namespace {

/// Instants beyond it are no recording's.
constexpr double kMostSeconds = 1e9;

std::int64_t mark_ns(std::int64_t number, const std::string& option, const ExportTable& table) {
  std::string all;
  for (const ExportMark& mark : table.mark) {
    if (mark.number == number) return table.start_ns + mark.time_ns;
    all += " " + std::to_string(mark.number);
  }
  throw ConfigError(option + ": " + std::to_string(number) + ": no such mark; " +
                    (all.empty() ? "the recording has none" : "allowed:" + all));
}

std::int64_t instant(std::int64_t zero_ns, double seconds, const std::string& option) {
  if (!(std::abs(seconds) <= kMostSeconds)) throw ConfigError(option + ": no time of a recording");
  return zero_ns + std::llround(seconds * 1e9);
}

Piece span_of(const TimeChoice& time, const ExportTable& table) {
  Piece span{std::numeric_limits<std::int64_t>::min(), Piece::kEver};
  const std::int64_t from_zero =
      time.from_mark ? mark_ns(*time.from_mark, "--from-mark", table) : table.start_ns;
  const std::int64_t to_zero = time.to_mark ? mark_ns(*time.to_mark, "--to-mark", table) : table.start_ns;
  if (time.from_s || time.from_mark) span.from_ns = instant(from_zero, time.from_s.value_or(0.0), "--from");
  if (time.to_s || time.to_mark) span.to_ns = instant(to_zero, time.to_s.value_or(0.0), "--to");
  if (span.to_ns <= span.from_ns) throw ConfigError("--to: not after --from; allowed: a later time");
  return span;
}

}  // namespace

Pieces find_pieces(const ExcerptRequest& request, const RecordingSurvey& survey, const ExportTable& table,
                   const std::stop_token& stop) {
  Pieces pieces{span_of(request.time, table)};
  if (!request.time.asks_samples()) return pieces;
  const JudgedTime judged = judge_time(request, survey, stop);
  if (request.time.least_m_s || request.time.most_m_s) pieces = common_of(pieces, judged.at_speed);
  if (request.time.clean) pieces = without(common_of(pieces, judged.covered), judged.unclean);
  std::erase_if(pieces, [&](const Piece& piece) {
    return piece.to_ns != Piece::kEver &&
           static_cast<double>(piece.to_ns - piece.from_ns) * 1e-9 < request.time.least_s;
  });
  if (pieces.empty())
    throw ConfigError("--speed, --clean: no stretch of " + std::to_string(request.time.least_s) +
                      " s is of that kind");
  return pieces;
}

}  // namespace roadbalance
