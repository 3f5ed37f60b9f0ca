#pragma once

#include <exception>
#include <string>

namespace roadbalance {

/// What went wrong, for people: the file, the cause, and where the system tells the cause what to do about
/// it: "/media/disk/a: No space left on device: make room on its disk, and begin again".
/// May be given to a terminal.
std::string failure_words(const std::exception& error);

}  // namespace roadbalance
