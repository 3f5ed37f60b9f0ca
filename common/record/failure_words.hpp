#pragma once

#include <exception>
#include <string>

namespace roadbalance {

/// A failure in words for people: the file, the cause, and where the cause is the system's, its remedy:
/// "/media/disk/a: No space left on device: make room on its disk, and begin again". May be given to a
/// terminal.
std::string failure_words(const std::exception& error);

}  // namespace roadbalance
