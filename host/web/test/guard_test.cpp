#include "host/web/guard.hpp"

#include <gtest/gtest.h>

#include <set>

namespace roadbalance {
namespace {

const OwnAddress kHere{"127.0.0.1", 8080};
const GuardRules kRules{{"localhost", "car.lan"}, "0123456789abcdef", true};

RequestHead page() {
  return {.method = "GET", .target = "/", .host = "127.0.0.1:8080"};
}
RequestHead feed() {
  return {.method = "GET",
          .target = "/feed",
          .host = "127.0.0.1:8080",
          .origin = "http://127.0.0.1:8080",
          .token = "0123456789abcdef",
          .is_websocket = true};
}
RequestHead change() {
  RequestHead head = feed();
  head.method = "POST";
  head.is_websocket = false;
  return head;
}

TEST(Guard, AdmitsOnlyHostsThatAreMeantForUs) {
  RequestHead head = page();
  EXPECT_EQ(admit(head, kHere, kRules), Admission::kAdmitted);
  for (const char* ours : {"localhost:8080", "car.lan:8080"}) {
    head.host = ours;
    EXPECT_EQ(admit(head, kHere, kRules), Admission::kAdmitted) << ours;
  }
  for (const char* other : {"", "127.0.0.1", "127.0.0.1:8081", "evil.example:8080",
                            "car.lan.evil.example:8080", "127.0.0.1:8080.evil.example", "0.0.0.0:8080"}) {
    head.host = other;
    EXPECT_EQ(admit(head, kHere, kRules), Admission::kHostUnknown) << other;
  }
}

TEST(Guard, BrowsersLeaveTheUsualPortOut) {
  RequestHead head = page();
  head.host = "127.0.0.1";
  EXPECT_EQ(admit(head, {"127.0.0.1", 80}, kRules), Admission::kAdmitted);
}

TEST(Guard, AWebSocketShowsThatItIsOfOurPage) {
  RequestHead head = feed();
  EXPECT_EQ(admit(head, kHere, kRules), Admission::kAdmitted);
  for (const char* origin : {"", "null", "http://evil.example", "https://127.0.0.1:8080",
                             "http://127.0.0.1:8081", "http://localhost:8080"}) {
    head.origin = origin;
    EXPECT_EQ(admit(head, kHere, kRules), Admission::kForeignOrigin) << origin;
  }
}

TEST(Guard, AStateChangeShowsOriginAndTokenEvenWhereWatchingNeedsNone) {
  GuardRules rules = kRules;
  rules.token_to_watch = false;
  RequestHead head = change();
  EXPECT_EQ(admit(head, kHere, rules), Admission::kAdmitted);
  head.origin = "http://evil.example";
  EXPECT_EQ(admit(head, kHere, rules), Admission::kForeignOrigin);
  head.origin = "";
  EXPECT_EQ(admit(head, kHere, rules), Admission::kForeignOrigin);
  head = change();
  for (const char* token : {"", "0123456789abcdeF", "0123456789abcde", "0123456789abcdef0"}) {
    head.token = token;
    EXPECT_EQ(admit(head, kHere, rules), Admission::kNoToken) << token;
  }
}

TEST(Guard, WatchingFromElsewhereNeedsTheToken) {
  RequestHead head = feed();
  head.token = "";
  EXPECT_EQ(admit(head, kHere, kRules), Admission::kNoToken);
  GuardRules local = kRules;
  local.token_to_watch = false;
  EXPECT_EQ(admit(head, kHere, local), Admission::kAdmitted);
}

TEST(Guard, WhatChangesOnlyWhatIsShownShowsOriginAndTheTokenOnlyWhereWatchingNeedsIt) {
  GuardRules local = kRules;
  local.token_to_watch = false;
  RequestHead head = change();
  head.only_watches = true;
  head.token = "";
  EXPECT_EQ(admit(head, kHere, local), Admission::kAdmitted);
  EXPECT_EQ(admit(head, kHere, kRules), Admission::kNoToken);
  for (const char* origin : {"", "null", "http://evil.example"}) {
    head.origin = origin;
    EXPECT_EQ(admit(head, kHere, local), Admission::kForeignOrigin) << origin;
  }
}

TEST(Guard, NoTokenIsNotAToken) {
  GuardRules rules = kRules;
  rules.token = "";
  RequestHead head = change();
  head.token = "";
  EXPECT_EQ(admit(head, kHere, rules), Admission::kNoToken);
}

TEST(Guard, AForeignPageMayNotEvenRead) {
  RequestHead head = page();
  head.origin = "http://evil.example";
  EXPECT_EQ(admit(head, kHere, kRules), Admission::kForeignOrigin);
}

TEST(Guard, KnowsThreeMethods) {
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "get", ""}) {
    RequestHead head = change();
    head.method = method;
    EXPECT_EQ(admit(head, kHere, kRules), Admission::kMethodUnknown) << method;
  }
}

TEST(Guard, FindsTheTokenAmongTheProtocols) {
  EXPECT_EQ(token_of_protocols("roadbalance, token.abc"), "abc");
  EXPECT_EQ(token_of_protocols("token.abc ,roadbalance"), "abc");
  EXPECT_EQ(token_of_protocols("roadbalance"), "");
  EXPECT_EQ(token_of_protocols("xtoken.abc"), "");
  EXPECT_EQ(token_of_protocols(""), "");
}

TEST(Guard, FindsTheViewerAmongTheProtocols) {
  EXPECT_EQ(viewer_of_protocols("roadbalance, viewer.9007199254740991"), 9'007'199'254'740'991);
  EXPECT_EQ(viewer_of_protocols("viewer.12 , token.abc"), 12);
  for (const char* none :
       {"", "roadbalance", "viewer.", "viewer.12x", "viewer.-8", "viewer.99999999999999999999"})
    EXPECT_EQ(viewer_of_protocols(none), 0) << none;
}

TEST(Guard, NoTwoTokensAreEqual) {
  std::set<std::string> tokens;
  for (int i = 0; i < 1000; ++i) tokens.insert(new_token());
  EXPECT_EQ(tokens.size(), 1000U);
  for (const auto& token : tokens) EXPECT_EQ(token.size(), 32U);
}

}  // namespace
}  // namespace roadbalance
