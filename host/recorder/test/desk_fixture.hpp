#pragma once

#include <gtest/gtest.h>

#include <cerrno>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/recorder/desk.hpp"

namespace roadbalance::test {

inline constexpr std::int64_t kNow = 1'769'860'805'000'000;  // 2026-01-31 12:00:05 UTC, as date(1) says

inline Request ask(Operation operation, std::int64_t number, std::string text = "") {
  return {.asker = 7, .request = number, .operation = operation, .text = std::move(text)};
}

// What the desk's hands did, and a disk whose book outlives it.
class DeskTest : public ::testing::Test {
 protected:
  Desk desk() {
    return Desk({.store =
                     [this](const DeskBook& now) {
                       if (disk_fails) throw std::system_error(ENOSPC, std::generic_category(), "write book");
                       book = now;
                     },
                 .exists =
                     [this](const std::string& name) {
                       if (disk_fails) throw std::system_error(EIO, std::generic_category(), "open " + name);
                       return taken.contains(name);
                     },
                 .begin = [this](const UnderWay& of) { done.push_back("begin " + of.name); },
                 .stop = [this] { done.push_back("stop"); },
                 .note =
                     [this](const NoteToRecord& note) {
                       const char* kind = note.kind == NoteKind::kMark ? "mark " : "asked ";
                       done.push_back(kind + std::to_string(note.a) + " " + note.text);
                     },
                 .set_up =
                     [this](const Request& request) {
                       set_up = request;
                       return Answer{.asker = request.asker,
                                     .request = request.request,
                                     .operation = request.operation};
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
                book);
  }
  static Answer last(Desk& desk) {
    const auto answers = desk.answers();
    return answers.empty() ? Answer{} : answers.back();
  }

  DeskBook book;
  std::set<std::string> taken;
  std::vector<std::string> done;
  Request set_up;  // the last
  bool disk_fails = false;
  bool sets_up = false;
  bool mark_fired = true;
};

}  // namespace roadbalance::test
