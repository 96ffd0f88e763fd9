#include "planegraph/base/heartbeat.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace planegraph {
namespace {

using std::chrono::milliseconds;
using testing::SizeIs;

constexpr milliseconds kInterval{20};

class Said {
 public:
  std::function<void(const std::string&)> Recorder() {
    return [this](const std::string& line) {
      const std::lock_guard<std::mutex> lock(mutex_);
      lines.push_back(line);
      changed_.notify_all();
    };
  }
  // However busy the machine is: whether so many lines come that begin like this.
  bool WaitFor(std::size_t count, const std::string& start) {
    std::unique_lock<std::mutex> lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(60), [&] {
      return std::count_if(lines.begin(), lines.end(), [&](const std::string& line) {
               return line.rfind(start, 0) == 0;
             }) >= static_cast<std::ptrdiff_t>(count);
    });
  }

  std::vector<std::string> lines;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
};

TEST(Heartbeat, SilentWorkShowsThatItLives) {
  Said said;
  {
    const Heartbeat heartbeat(kInterval, said.Recorder());
    EXPECT_TRUE(said.WaitFor(3, "at work, "));
  }
}

TEST(Heartbeat, NamesTheStage) {
  Said said;
  {
    Heartbeat heartbeat(kInterval, said.Recorder());
    heartbeat.Report("registration", 0.507);
    EXPECT_TRUE(said.WaitFor(3, "registration 50 %, "));
  }
}

TEST(Heartbeat, ManyReportsAreFewLines) {
  Said said;
  const auto start = Heartbeat::Clock::now();
  {
    Heartbeat heartbeat(kInterval, said.Recorder());
    const auto report = [&](int from) {
      for (int k = from; k < from + 2000; ++k) heartbeat.Report("scans", k / 4000.0);
    };
    std::thread other(report, 0);
    report(2000);
    other.join();
  }
  EXPECT_LE(said.lines.size(), (Heartbeat::Clock::now() - start) / kInterval);
}

TEST(Heartbeat, ShortWorkSaysNothing) {
  Said said;
  {
    Heartbeat heartbeat(std::chrono::hours(1), said.Recorder());
    for (int k = 0; k < 1000; ++k) heartbeat.Report("scans", k / 1000.0);
  }
  EXPECT_THAT(said.lines, SizeIs(0));
}

}  // namespace
}  // namespace planegraph
