#pragma once

#include <cstdint>
#include <string>

#include "host/excerpt/excerpt_request.hpp"
#include "host/excerpt/pieces.hpp"

namespace roadbalance {

/// "every 4th sample of monday, from 60 s to 120 s; nodes front": what a recording is made of, for people.
std::string excerpt_words(const ExcerptRequest& request);
/// "from 12.000 s to 20.500 s", since the original's first sample.
std::string piece_words(const Piece& piece, std::int64_t start_ns);

/// An epoch's number for a piece of it: another for another excerpt, the same for the same (FNV-1a).
std::int64_t excerpt_epoch_number(std::int64_t epoch, const std::string& words, const Piece& piece);

}  // namespace roadbalance
