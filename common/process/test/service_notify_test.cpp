#include "common/process/service_notify.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <stdexcept>

#include "common/test/notify_socket.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

TEST(ServiceNotify, SaysWhatSystemdUnderstands) {
  const test::TemporaryDirectory folder;
  const test::NotifySocket supervisor(folder / "notify");
  ServiceNotify notify;
  EXPECT_TRUE(notify.has_supervisor());
  notify.ready();
  EXPECT_EQ(supervisor.heard(), "READY=1");
  notify.feed();
  EXPECT_EQ(supervisor.heard(), "WATCHDOG=1");
  notify.status("2 nodes");
  EXPECT_EQ(supervisor.heard(), "STATUS=2 nodes");
  notify.stopping();
  EXPECT_EQ(supervisor.heard(), "STOPPING=1");
  EXPECT_EQ(notify.unsent(), 0);
}

TEST(ServiceNotify, DoesNothingWithoutASupervisor) {
  ::unsetenv("NOTIFY_SOCKET");
  ServiceNotify notify;
  EXPECT_FALSE(notify.has_supervisor());
  notify.ready();
  EXPECT_EQ(notify.unsent(), 0);
}

TEST(ServiceNotify, GoesOnWhenTheSupervisorIsGoneAndCountsIt) {
  const test::TemporaryDirectory folder;
  ::setenv("NOTIFY_SOCKET", (folder / "nobody").c_str(), 1);
  ServiceNotify notify;
  notify.feed();
  EXPECT_EQ(notify.unsent(), 2);  // neither connected nor sent
  ::unsetenv("NOTIFY_SOCKET");
}

TEST(ServiceNotify, NamesAVariableThatIsNoAddress) {
  ::setenv("NOTIFY_SOCKET", "relative/path", 1);
  EXPECT_THROW(ServiceNotify(), std::runtime_error);
  ::unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace roadbalance
