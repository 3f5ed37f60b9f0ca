// What Operating does to vehicle.toml.
#include "host/recorder/desk_answers.hpp"
#include "host/recorder/operating.hpp"

namespace roadbalance {

Answer Operating::no_vehicle(const Request& request) const {
  Answer answer = answer_to(request, time_.utc_us);
  answer.state = AnswerState::kRefused;
  answer.reason = RefusalReason::kNotSupported;
  answer.text = no_set_up_;
  return answer;
}

Answer Operating::set_up(const Request& request) {
  if (set_up_) return set_up_->take(request, heard_.nodes(time_.now), time_.utc_us, time_.now);
  return no_vehicle(request);
}

Answer Operating::read_mark(const Request& request) {
  if (set_up_) return mark_readings_.take(request, set_up_->vehicle(), time_.now);
  return no_vehicle(request);
}

}  // namespace roadbalance
