#include "host/excerpt/excerpt_words.hpp"

#include <cstdio>
#include <limits>

namespace roadbalance {
namespace {

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::string ordinal(int factor) {
  const bool teen = factor % 100 / 10 == 1;
  const char* const ending = teen               ? "th"
                             : factor % 10 == 1 ? "st"
                             : factor % 10 == 2 ? "nd"
                             : factor % 10 == 3 ? "rd"
                                                : "th";
  return std::to_string(factor) + ending;
}

std::string list(const std::string& title, const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "; " + title + " " : ", ") + name;
  return text;
}

std::string limit(const char* title, const std::optional<double>& seconds,
                  const std::optional<std::int64_t>& mark) {
  if (!seconds && !mark) return "";
  std::string text = std::string(title) + number(seconds.value_or(0.0)) + " s";
  if (mark) text += " of mark " + std::to_string(*mark);
  return text;
}

}  // namespace

std::string excerpt_words(const ExcerptRequest& request) {
  const TimeChoice& time = request.time;
  std::string text = request.factor > 1 ? "every " + ordinal(request.factor) + " sample of " : "part of ";
  text += std::filesystem::canonical(request.folder).filename().string();
  text += limit(", from ", time.from_s, time.from_mark) + limit(", to ", time.to_s, time.to_mark);
  if (time.least_m_s) text += ", at " + number(*time.least_m_s * 3.6) + " km/h and more";
  if (time.most_m_s) text += ", below " + number(*time.most_m_s * 3.6) + " km/h";
  if (time.clean) text += ", clean";
  return text + list("nodes", request.choice.nodes) + list("channels", request.choice.channels);
}

std::string piece_words(const Piece& piece, std::int64_t start_ns) {
  char text[96];
  const auto seconds = [&](std::int64_t ns) { return static_cast<double>(ns - start_ns) * 1e-9; };
  if (piece.from_ns == std::numeric_limits<std::int64_t>::min())
    std::snprintf(text, sizeof text, "from the beginning");
  else
    std::snprintf(text, sizeof text, "from %.3f s", seconds(piece.from_ns));
  std::string words = text;
  if (piece.to_ns == Piece::kEver) return words + " to the end";
  std::snprintf(text, sizeof text, " to %.3f s", seconds(piece.to_ns));
  return words + text;
}

std::int64_t excerpt_epoch_number(std::int64_t epoch, const std::string& words, const Piece& piece) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto mix = [&](const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211ULL;
  };
  mix(&epoch, sizeof epoch);
  mix(words.data(), words.size());
  mix(&piece.from_ns, sizeof piece.from_ns);
  mix(&piece.to_ns, sizeof piece.to_ns);
  return static_cast<std::int64_t>(hash >> 2) + 1;
}

}  // namespace roadbalance
