#pragma once

#include <gtest/gtest.h>

#include <cerrno>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/recorder/control/session_controller.hpp"

namespace roadbalance::test {

inline constexpr std::int64_t kNow = 1'769'860'805'000'000;  // 2026-01-31 12:00:05 UTC, as date(1) says

inline Request ask(Operation operation, std::int64_t number, std::string text = "") {
  return {.asker = 7, .request = number, .operation = operation, .text = std::move(text)};
}

// The callbacks that were made, and a disk whose session state outlives the controller.
class SessionControllerTest : public ::testing::Test {
 protected:
  SessionController controller() {
    return SessionController(
        {.store =
             [this](const SessionState& now) {
               if (disk_fails)
                 throw std::system_error(ENOSPC, std::generic_category(), "write session state");
               state = now;
             },
         .taken_by =
             [this](const std::string& name) {
               if (disk_fails) throw std::system_error(EIO, std::generic_category(), "open " + name);
               return taken.contains(name) ? name : "";
             },
         .begin = [this](const ActiveRecording& of) { done.push_back("begin " + of.name); },
         .stop =
             [this](const std::string& by) {
               done.push_back("stop");
               stopped_by = by;
             },
         .choose = [this](const std::string&) { return chosen; },
         .note =
             [this](const NoteToRecord& note) {
               const char* kind = note.kind == NoteKind::kMark ? "mark " : "asked ";
               done.push_back(kind + std::to_string(note.a) + " " + note.text);
             },
         .set_up =
             [this](const Request& request) {
               set_up = request;
               return Answer{
                   .asker = request.asker, .request = request.request, .operation = request.operation};
             },
         .asked_set_up =
             [this] {
               return AskedSetUp{.asked = {set_up.asker, set_up.request},
                                 .operation = set_up.operation,
                                 .value = set_up.value,
                                 .vehicle_crc32c = 5};
             },
         .forget_set_up = [this] { done.push_back("forget"); },
         .is_set_up_under_way = [this] { return sets_up; },
         .read_mark =
             [this](const Request& request) {
               done.push_back("read");
               return Answer{.asker = request.asker,
                             .request = request.request,
                             .operation = request.operation,
                             .state = mark_fired ? AnswerState::kDone : AnswerState::kRefused,
                             .reason = mark_fired ? RefusalReason::kNone : RefusalReason::kMoving,
                             .value = {0.5, 0.01},
                             .text = mark_fired ? "read" : "it turns"};
             }},
        state);
  }
  static Answer last(SessionController& controller) {
    const auto answers = controller.answers();
    return answers.empty() ? Answer{} : answers.back();
  }

  SessionState state;
  std::set<std::string> taken;
  std::vector<std::string> done;
  ChosenNodes chosen;
  std::string stopped_by;
  Request set_up;  // the last
  bool disk_fails = false;
  bool sets_up = false;
  bool mark_fired = true;
};

}  // namespace roadbalance::test
