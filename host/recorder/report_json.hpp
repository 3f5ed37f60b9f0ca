#pragma once

#include <string>

#include "host/recorder/recorder.hpp"

namespace roadbalance {

/// {"nodes":[{"node":1,"epoch":...,"samples_sent":...,"samples_recorded":...,"gaps":...,"repaired":...,...}],...}
std::string to_json(const RecorderReport& report);

}  // namespace roadbalance
